"""How far a search is: a bar on a terminal, plain lines anywhere else."""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.terminal import progress_console
from mrsfi_runtime.record.settings import CampaignSettings

if TYPE_CHECKING:
    from mrsfi_runtime.kernel.state import State
    from mrsfi_runtime.record.store import CampaignStore
    from mrsfi_runtime.search.run import CampaignProgress

_LINES = 100
"""About how many plain lines a long search prints."""

_EVERY = 5.0
"""Seconds between two lines about a flight."""

_PACE = 8
"""Lines that tell how fast a search is now: it may be compiled since."""


@contextmanager
def search_progress(store: "CampaignStore") -> "Iterator[Callable[[CampaignProgress], None]]":
    """Yield the function to call after each generation of a campaign that may be begun already."""
    settings = store.settings
    begun = _share(settings, store.n_generations, store.n_evaluations + store.n_failures)
    console = progress_console()
    if not console.is_terminal:
        yield PlainLines(settings, monotonic, begun)
        return
    columns = (
        TextColumn("generation {task.fields[generation]}"),
        BarColumn(),
        TextColumn("best {task.fields[best]:.2f}  mean {task.fields[mean]:.2f}  left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=1.0, generation="0", best=0.0, mean=0.0)
        bar.update(task, completed=begun)

        def advance(state: "CampaignProgress") -> None:
            bar.update(
                task,
                completed=share_done(settings, state),
                generation=_generation(settings, state),
                best=state.best,
                mean=state.mean,
            )

        yield advance


class PlainLines:
    """Writes a line after a generation, at most some hundred in a search.

    ``begun`` is the share of it that was done before, ``clock`` counts seconds.
    """

    def __init__(
        self, settings: CampaignSettings, clock: Callable[[], float], begun: float = 0.0
    ) -> None:
        self._settings = settings
        self._recorded = begun
        self._clock = clock
        self._recent = deque([(clock(), begun)], maxlen=_PACE)
        self._told = -1.0

    def __call__(self, state: "CampaignProgress") -> None:
        """Tell how far the search is after a generation."""
        done = share_done(self._settings, state)
        if done < 1.0 and (done <= self._recorded or done - self._told < 1.0 / _LINES):
            return
        self._told = done
        since, before = self._recent[0]
        now = self._clock()
        self._recent.append((now, done))
        left = round((now - since) * (1.0 - done) / (done - before)) if done < 1.0 else 0
        tell(
            f"generation {_generation(self._settings, state)}  best {state.best:.2f}  "
            f"mean {state.mean:.2f}  evaluations {state.n_evaluations}  "
            f"left {left // 60}:{left % 60:02d}"
        )


class FlightProgress:
    """Observer that tells how far a flight of some ticks is, every few seconds."""

    def __init__(self, duration: int, clock: Callable[[], float] = monotonic) -> None:
        self._duration = duration
        self._clock = clock
        self._began = self._told = clock()

    def __call__(self, world: "State", *_: object) -> None:
        """Tell after a tick, if it is time."""
        now = self._clock()
        if now - self._told < _EVERY:
            return
        self._told = now
        n_done = world.mission.tick + 1
        left = round((now - self._began) / n_done * (self._duration - n_done))
        tell(f"tick {n_done:,} of {self._duration:,}  left {left // 60}:{left % 60:02d}")


def share_done(settings: CampaignSettings, state: "CampaignProgress") -> float:
    """Return the share of a search that is done, above 0, at most 1."""
    return _share(settings, state.generation + 1, state.n_evaluations + state.n_failures)


def _share(settings: CampaignSettings, n_generations: int, n_asked: int) -> float:
    """Return the share of a search that so many generations or specifications are."""
    if settings.evaluations is not None:
        return min(1.0, n_asked / settings.evaluations)
    return min(1.0, n_generations / (settings.generations + 1))


def _generation(settings: CampaignSettings, state: "CampaignProgress") -> str:
    if settings.evaluations is not None:
        return str(state.generation)
    width = len(str(settings.generations))
    return f"{state.generation:>{width}}/{settings.generations}"
