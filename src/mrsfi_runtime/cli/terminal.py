"""Print results to standard output and progress to standard error.

Rich lays out tables, wrapped text and progress bars. Functions import it when they need it, so
that this module is quick to import. Without a terminal, progress is plain lines.
"""

import json
import os
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from io import BufferedWriter, FileIO, TextIOWrapper
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import click

from mrsfi_runtime.errors import time_left

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table as Grid

    from mrsfi_runtime.analysis.tables import Table
    from mrsfi_runtime.cosimulation.lockstep import Observer
    from mrsfi_runtime.kernel.state import State
    from mrsfi_runtime.record.settings import CampaignSettings
    from mrsfi_runtime.record.store import CampaignStore
    from mrsfi_runtime.search.run import CampaignProgress


class Sink(FileIO):
    """A stream whose writes never raise an error; it keeps the first one."""

    error: OSError | None = None

    def write(self, content: Any) -> int:
        """Write; if that fails, act as if it had succeeded."""
        try:
            return super().write(content) or 0
        except OSError as error:
            self.error = self.error or error
            return len(content)


def steady_output() -> Sink | None:
    """Keep a command running if the disk is full, the reader has gone or a character has no code.

    Returns the new standard output; ``None`` if something captures standard output.
    """
    while None in (sys.stdin, sys.stdout, sys.stderr) and os.open(os.devnull, os.O_RDWR) < 2:
        pass  # or the next file that is opened would be standard output
    for number, name in ((2, "stderr"), (1, "stdout")):
        stream = getattr(sys, name)
        output = None
        if stream is getattr(sys, f"__{name}__"):
            output = Sink(number, "w", closefd=False)
            encoding = stream.encoding if stream else "utf-8"
            lines, buffer = name == "stderr" or output.isatty(), BufferedWriter(output)
            steady = TextIOWrapper(buffer, encoding, "backslashreplace", line_buffering=lines)
            setattr(sys, name, steady)
    return output


def print_json(value: Any) -> None:
    """Print a value as JSON."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def write_file(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, and report it."""
    from mrsfi_runtime.files import whole_file

    with whole_file(path) as file:
        file.write(content)
    tell(f"written    {path}")


def print_changes(respelt: Iterable[Path], difference: Iterable[str]) -> None:
    """Print a unified diff of models, after the files whose layout changes as well."""
    for path in respelt:
        click.echo(f"{path}: is not as Eclipse writes it; layout and comments will be lost")
    for line in difference:
        click.echo(line)


def tell(message: str) -> None:
    """Print one line of progress."""
    click.echo(message, err=True)


_EVERY = 5.0  # seconds between two lines about a flight
_LEAST = 16  # minimum width of a column of wrapped text, unless the text is shorter


def progress_console() -> "Console":
    """Return the console of standard error; it has motion and colour on a terminal only."""
    from rich.console import Console

    return Console(file=sys.stderr, highlight=False)


def print_table(table: "Table") -> None:
    """Print a table to standard output; if it is too wide, leave columns out and name them.

    No number, ID or word is cut: if the table is still too wide, it takes the width that it needs.
    The width is COLUMNS, or else that of the terminal, or else 100, so that a table is the same in
    every pipe and log file.
    """
    from rich.text import Text

    console = _console()
    shown = table
    grid, needed = _laid_out(console, table)
    for narrower in table.narrower():
        if needed > console.width:
            shown, (grid, needed) = narrower, _laid_out(console, narrower, is_tight=True)
    console.width = max(console.width, needed)
    console.print(Text(table.title, style="bold"))
    console.print(grid)
    if left_out := [name for name in table.spare if name not in shown.columns]:
        print_words(f"Left out for lack of width: {', '.join(left_out)}")
    console.print()


def print_words(*parts: str | tuple[str, str], indent: int = 0) -> None:
    """Print a text to standard output, wrapped; parts may have a style, such as ``bold red``."""
    from rich.text import Text

    words = Text()
    for part in parts:
        text, style = (part, "") if isinstance(part, str) else part
        words.append("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text), style)
    console = _console()
    for line in words.wrap(console, console.width - indent):
        line.rstrip()
        console.print(Text(" " * indent) + line)


def _console() -> "Console":
    from rich.console import Console

    given = os.environ.get("COLUMNS", "")
    width = int(given) if given.isdecimal() and int(given) > 0 else None
    console = Console(file=sys.stdout, highlight=False, width=width)
    if width is None and not console.is_terminal:
        console.width = 100
    return console


def _laid_out(console: "Console", table: "Table", *, is_tight: bool = False) -> "tuple[Grid, int]":
    """Return a table, in which cells are never read as markup, and the width that it needs.

    If it is tight, numbers and column names wrap at spaces.
    """
    from rich import box
    from rich.table import Table as Grid
    from rich.text import Text

    from mrsfi_runtime.analysis.tables import in_words

    padding = (0, 1, 0, 0) if table.is_compact else (0, 1)
    grid = Grid(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=padding)
    for name in table.columns:
        is_word = name in table.words and name not in table.texts
        grid.add_column(
            Text(name.replace(" ", "\n") if table.is_compact else name),
            justify="left" if is_word or name in table.texts else "right",
            no_wrap=is_word,
            overflow="fold",
        )
    for row in table.rows:
        grid.add_row(*(Text(in_words(cell)) for cell in row))
    whole = console.options.update(width=100_000)  # wider than any table
    for name, column in zip(table.columns, grid.columns, strict=True):
        cells = (column.header, *column.cells)
        sizes = [console.measure(cell, options=whole) for cell in cells]
        longest = max(each.maximum for each in sizes)
        if name in table.texts and name not in table.folded[1]:
            column.min_width = min(_LEAST, longest)
        elif not is_tight or name in (*table.words, *table.texts):
            column.min_width = longest
        else:  # otherwise rich makes it narrower than its longest number
            column.width = max(each.minimum for each in sizes)
    return grid, console.measure(grid, options=whole).minimum


@contextmanager
def search_progress(store: "CampaignStore") -> "Iterator[Callable[[CampaignProgress], None]]":
    """Yield the function to call after each generation of a new or resumed campaign."""
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
            done, words = share_done(settings, state), _generation(settings, state)
            bar.update(task, completed=done, generation=words, best=state.best, mean=state.mean)

        yield advance


def plain_lines(
    settings: "CampaignSettings", clock: Callable[[], float], begun: float = 0.0
) -> "Callable[[CampaignProgress], None]":
    """Return a function that prints a line after a generation, about 100 in a search."""
    recent = deque([(clock(), begun)], maxlen=8)  # give the pace, which changes once compiled
    printed = -1.0

    def tell_after(state: "CampaignProgress") -> None:
        nonlocal printed
        done = share_done(settings, state)
        if done < 1.0 and (done <= begun or done - printed < 0.01):
            return
        printed = done
        since, before = recent[0]
        now = clock()
        recent.append((now, done))
        rest = (now - since) * (1.0 - done) / (done - before) if done < 1.0 else 0.0
        tell(
            f"generation {_generation(settings, state)}  best {state.best:.2f}  "
            f"mean {state.mean:.2f}  evaluations {state.n_evaluations}  {time_left(rest)}"
        )

    return tell_after


def flight_progress(duration: int, clock: Callable[[], float] = monotonic) -> "Observer":
    """Return an observer that prints every few seconds how many ticks of a flight are done."""
    began = printed = clock()

    def tell_after(world: "State", *_: object) -> None:
        nonlocal printed
        now = clock()
        if now - printed < _EVERY:
            return
        printed = now
        n_done = world.mission.tick + 1
        rest = (now - began) / n_done * (duration - n_done)
        tell(f"tick {n_done:,} of {duration:,}  {time_left(rest)}")

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
