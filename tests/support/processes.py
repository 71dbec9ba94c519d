"""Processes that others have started, as the kernel tells of them."""

from collections.abc import Callable, Iterable
from pathlib import Path
from time import monotonic, sleep


def is_running(pid: int) -> bool:
    """Return whether a process runs; one that waits to be collected does not."""
    try:
        return _state(Path(f"/proc/{pid}/stat"))[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def children(pid: int, word: bytes = b"") -> list[int]:
    """Return the processes that a process has started whose command line has a word."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            is_child = int(_state(stat)[1]) == pid
            if is_child and word in stat.with_name("cmdline").read_bytes():
                found.append(int(stat.parent.name))
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found


def descendants(pid: int) -> list[int]:
    """Return the processes that a process has started, and those that they have started."""
    found = children(pid)
    return found + [each for child in found for each in descendants(child)]


def wait_for(condition: Callable[[], object], within: float = 30.0) -> None:
    """Wait until a condition holds, at most so many seconds."""
    limit = monotonic() + within
    while not condition():
        assert monotonic() < limit, f"not within {within} s"
        sleep(0.01)


def require_end(processes: Iterable[int], within: float = 20.0) -> None:
    """Require that processes end, within so many seconds."""
    wait_for(lambda: not any(map(is_running, processes)), within)


def _state(stat: Path) -> list[str]:
    """Return what follows the name of a process: its state, its parent and more."""
    return stat.read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
