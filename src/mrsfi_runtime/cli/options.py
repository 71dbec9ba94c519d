"""What several commands take: a mission, an engine, workers, files of a flight."""

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import click

from mrsfi.engines import EngineOptions, Workers
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cosimulation.waiting import Patience
from mrsfi_runtime.engine.node_settings import RESETS
from mrsfi_runtime.engine.settings import ENGINES, REFERENCE
from mrsfi_runtime.errors import expected
from mrsfi_runtime.record.manifest import BOTH, CI, INJECTOR
from mrsfi_runtime.transport.topics import CLIENTS, ROS_VERSIONS

F = TypeVar("F", bound=Callable[..., Any])

mission_argument = click.argument("mission", metavar="MISSION")
"""Gives a command the argument MISSION."""

FILE = click.Path(path_type=Path, dir_okay=False)
"""What an option is that names a file."""


def file_option(name: str, text: str) -> Callable[[F], F]:
    """Give a command an option that names a file, with the text of its help."""
    return click.option(name, type=FILE, metavar="FILE", help=text)


def folder_option(name: str, text: str) -> Callable[[F], F]:
    """Give a command an option that names a folder, with the text of its help."""
    kind = click.Path(path_type=Path, file_okay=False)
    return click.option(name, type=kind, metavar="DIR", help=text)


def seeds_option(text: str) -> Callable[[F], F]:
    """Give a command the option --seeds, with the text of its help."""
    kind = click.IntRange(1, 1000)
    return click.option("--seeds", "n_seeds", type=kind, metavar="N", help=text)


generated_option = folder_option(
    "--generated", "Folder of the generated code [default: generated/NAME beside models/]."
)
"""Gives a command the option --generated."""


def tell_of_metamodels() -> None:
    """Tell where the metamodels are, unless they are those of mrsfi."""
    from mrsfi.models import own_metamodels

    folder = own_metamodels()
    if folder is not None:
        tell(f"metamodels {folder}, which are not those of mrsfi")


SIMULATION = "simulation"


class OneOf(click.Choice[str]):
    """A choice that also says what may have been meant."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:  # noqa: ARG002 - click's signature
        """Return the message for a value that is none of the choices."""
        return f"found {value!r}; {expected(value, self.choices)}"


def options_as(
    name: str, kind: type[Any], options: Sequence[Callable[[Any], Any]]
) -> Callable[[F], F]:
    """Return the decorator that gives a command options, and passes them as one argument.

    The argument is a dataclass whose fields are named as the options' parameters; the options are
    decorators of click, in the order of the help.
    """

    def decorate(command: F) -> F:
        @wraps(command)
        def collected(*arguments: Any, **given: Any) -> Any:
            value = kind(**{field.name: given.pop(field.name) for field in fields(kind)})
            return command(*arguments, **{name: value}, **given)

        decorated: Any = collected
        for option in reversed(options):
            decorated = option(decorated)
        return cast("F", decorated)

    return decorate


_NODE_OPTIONS = (
    click.option(
        "--node",
        metavar="COMMAND",
        help="With --side injector: starts your node; {url} and {seed} are filled in.",
    ),
    click.option(
        "--node-pace",
        metavar="answer|barrier|RATE",
        help="When your node has answered a tick: by a message, by pings, by the clock (Hz).",
    ),
    click.option(
        "--node-reset",
        type=OneOf(RESETS),
        help="How your node begins anew [default: restart, or service without --node].",
    ),
    click.option("--node-prefix", metavar="/PREFIX", help="Before all topics of your node."),
)
"""Options of a team's own node."""


def engine_options(
    *, default: str = REFERENCE, sides: Sequence[str] = (BOTH, CI, INJECTOR)
) -> Callable[[F], F]:
    """Give a command the options of the engine, which it receives as ``engine``."""
    options = (
        click.option(
            "--engine",
            type=OneOf(ENGINES),
            show_default=default,
            help="How to fly: in this process, compiled or not, or on a rosbridge server.",
        ),
        click.option(
            "--url",
            metavar="ws://…",
            help="With --engine rosbridge: the server [default: one is embedded].",
        ),
        click.option(
            "--ros",
            type=OneOf([str(version) for version in ROS_VERSIONS]),
            help="With --engine rosbridge: version of ROS [default: the project's, or 1].",
        ),
        click.option(
            "--client",
            type=OneOf(CLIENTS),
            show_default=CLIENTS[0],
            help="With --engine rosbridge: kind of connection: ours, or one of roslibpy's.",
        ),
        click.option(
            "--side",
            type=OneOf(sides),
            show_default=BOTH,
            help="What this command runs: ci leaves the simulation to others, injector your node.",
        ),
        click.option(
            "--bundle/--no-bundle",
            default=None,
            help="With --engine rosbridge: all messages of a tick as one, for speed.",
        ),
        click.option(
            "--timeout",
            type=click.FloatRange(min=0, min_open=True),
            metavar="SECONDS",
            help=f"How long the other side may be silent [default: {Patience().tick:g}].",
        ),
        click.option(
            "--world-prefix", metavar="/PREFIX", help="With --url: before all topics of the world."
        ),
        *_NODE_OPTIONS,
    )
    return options_as("engine", EngineOptions, options)


worker_options = options_as(
    "workers",
    Workers,
    (
        click.option(
            "--workers",
            "number",
            type=click.IntRange(1),
            help="Processes that evaluate [default: as many as this machine has processors].",
        ),
        click.option(
            "--dask",
            metavar="tcp://…|local",
            help="Evaluate on a dask cluster: its scheduler, or a local one of --workers.",
        ),
    ),
)
"""Gives a command the options of the workers; it receives them as ``workers``."""


@dataclass(frozen=True, slots=True)
class FlightFiles:
    """Files that the command line wants of a flight; ``None`` where it wants none."""

    log: Path | None = None
    trace: Path | None = None
    mcap: Path | None = None
    html: Path | None = None
    gif: Path | None = None

    @property
    def wanted(self) -> tuple[Path, ...]:
        """Those that it names."""
        return tuple(path for path in astuple(self) if path is not None)


recording_options = options_as(
    "files",
    FlightFiles,
    (
        file_option(
            "--log",
            "Write the simulation log to FILE: robots each tick, mistaken beliefs, and events.",
        ),
        file_option("--trace", "Write belief and truth of every tick to FILE as CSV."),
        file_option("--mcap", "Write the flight to FILE as a bag, for Foxglove or RViz."),
        file_option("--html", "Write the flight to FILE as a page, to be played in a browser."),
        file_option("--gif", "Write the flight to FILE as an animated picture."),
    ),
)
"""Gives a command the options of files of a flight; it receives them as ``files``."""
