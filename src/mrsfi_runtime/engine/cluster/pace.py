"""How many specifications a chunk gets, from how long evaluations take."""

CHUNK_SECONDS = 0.35
"""What a chunk should take: long beside dask's 2 ms for a task, short if its worker is lost."""

_FIRST_GUESS = 0.05


class Pace:
    """Follows how long one evaluation takes on a worker.

    Nothing but the speed depends on it.
    """

    def __init__(self) -> None:
        self._seconds: float | None = None

    def learn(self, n_evaluations: int, seconds: float) -> None:
        """Take a chunk into account; the later it came, the more it counts."""
        found = seconds / n_evaluations
        self._seconds = found if self._seconds is None else (self._seconds + found) / 2

    def chunk_size(self, n_specifications: int, n_workers: int) -> int:
        """Return how many of some specifications to evaluate in one go, all workers alike."""
        seconds = _FIRST_GUESS if self._seconds is None else self._seconds
        n_workers = max(n_workers, 1)
        most = max(1, int(CHUNK_SECONDS / max(seconds, 1e-6))) * n_workers
        n_rounds = max(1, -(-n_specifications // most))
        return max(1, -(-n_specifications // (n_rounds * n_workers)))
