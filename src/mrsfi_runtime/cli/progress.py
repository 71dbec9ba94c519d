"""How far a search is: a bar on a terminal, plain lines anywhere else."""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

from mrsfi_runtime.cli.console import left, tell
from mrsfi_runtime.cli.terminal import progress_console

if TYPE_CHECKING:
    from mrsfi_runtime.cosimulation.lockstep import Observer
    from mrsfi_runtime.kernel.state import State
    from mrsfi_runtime.record.settings import CampaignSettings
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
        yield plain_lines(settings, monotonic, begun)
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

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


def plain_lines(
    settings: "CampaignSettings", clock: Callable[[], float], begun: float = 0.0
) -> "Callable[[CampaignProgress], None]":
    """Return what writes a line after a generation, at most some hundred in a search."""
    recent = deque([(clock(), begun)], maxlen=_PACE)
    told = -1.0

    def tell_after(state: "CampaignProgress") -> None:
        nonlocal told
        done = share_done(settings, state)
        if done < 1.0 and (done <= begun or done - told < 1.0 / _LINES):
            return
        told = done
        since, before = recent[0]
        now = clock()
        recent.append((now, done))
        rest = (now - since) * (1.0 - done) / (done - before) if done < 1.0 else 0.0
        tell(
            f"generation {_generation(settings, state)}  best {state.best:.2f}  "
            f"mean {state.mean:.2f}  evaluations {state.n_evaluations}  {left(rest)}"
        )

    return tell_after


def flight_progress(duration: int, clock: Callable[[], float] = monotonic) -> "Observer":
    """Return an observer that tells how far a flight of some ticks is, every few seconds."""
    began = told = clock()

    def tell_after(world: "State", *_: object) -> None:
        nonlocal told
        now = clock()
        if now - told < _EVERY:
            return
        told = now
        n_done = world.mission.tick + 1
        rest = (now - began) / n_done * (duration - n_done)
        tell(f"tick {n_done:,} of {duration:,}  {left(rest)}")

    return tell_after


def share_done(settings: "CampaignSettings", state: "CampaignProgress") -> float:
    """Return the share of a search that is done, above 0, at most 1."""
    return _share(settings, state.generation + 1, state.n_evaluations + state.n_failures)


def _share(settings: "CampaignSettings", n_generations: int, n_asked: int) -> float:
    if settings.evaluations is not None:
        return min(1.0, n_asked / settings.evaluations)
    return min(1.0, n_generations / (settings.generations + 1))


def _generation(settings: "CampaignSettings", state: "CampaignProgress") -> str:
    if settings.evaluations is not None:
        return str(state.generation)
    width = len(str(settings.generations))
    return f"{state.generation:>{width}}/{settings.generations}"
