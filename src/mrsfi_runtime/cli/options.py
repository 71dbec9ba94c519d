"""Options that several commands share: mission, engine, workers, files of a flight.

``options`` makes options of the fields of a data class; the metadata of a field has its help. A
command receives the data class as one argument. To give every command that flies a new option, add
a field. ``Command`` prints the options of a command in groups.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import Field, astuple, dataclass, fields
from functools import partial, wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import click

from mrsfi_runtime.cli.terminal import tell
from mrsfi_runtime.errors import expected
from mrsfi_runtime.record import engine_settings
from mrsfi_runtime.record.engine_settings import REFERENCE, SIDES, EngineSettings, Workers, option

F = TypeVar("F", bound=Callable[..., Any])

BUS = "Your own simulator or node"
"""Head of the options of a bus; after them comes the head "Output"."""

_HEADS = {"--case": "Search", "--help": "Options"}  # by their first options


class Command(click.Command):
    """A command whose help lists its options in groups; ``mrsfi help bus`` has those of a bus."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options below heads, which follow from their order; of a bus only the names."""
        head, groups = "Options", dict[str, list[tuple[str, str]]](Options=[])
        for each in self.get_params(ctx):
            if each.name in OF_ENGINE:
                head = BUS if each.name in OF_BUS else "Engine"
            else:
                head = _HEADS.get(each.opts[-1], "Output" if head == BUS else head)
            record = each.get_help_record(ctx)
            if record is not None and isinstance(each, click.Option):
                groups.setdefault(head, []).append(record)
        for head, rows in groups.items():
            with formatter.section(head):
                if head == BUS:
                    names = ", ".join(name.split()[0] for name, _ in rows)
                    formatter.write_text(f"{names}: see `mrsfi help bus`")
                else:
                    formatter.write_dl(rows)


command = partial(click.command, cls=Command)
"""Makes a function a command with groups of options."""

mission_argument = click.argument("mission", metavar="MISSION")
FILE = click.Path(path_type=Path, dir_okay=False)
"""The type of an option that names a file."""


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


def print_metamodels() -> None:
    """Print where the metamodels are if they are the project's."""
    from mrsfi.models import own_metamodels

    folder = own_metamodels()
    if folder is not None:
        tell(f"metamodels {folder} (the project's, not mrsfi's)")


SIMULATION = "simulation"


class OneOf(click.Choice[Any]):
    """A choice that suggests the nearest value for a wrong one."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:  # noqa: ARG002 - click's signature
        """Return the message for a value that is none of the choices."""
        return f"found {value!r}; {expected(value, self.choices)}"


KINDS: Mapping[Any, click.ParamType[Any]] = {
    int: click.INT,
    float: click.FloatRange(min=0, min_open=True),
    Path | None: FILE,
}
"""The type of an option by the type of its field; other fields take any text."""


def options(
    argument: str, settings: type[Any], make: Callable[..., Any], **other: Mapping[str, Any]
) -> Callable[[F], F]:
    """Return the decorator that gives a command the options of fields, passed as one argument.

    ``make`` makes the argument from the given fields, by name. ``other`` has, by the name of a
    field, the default or the choices for this command.
    """
    known = [each for each in fields(settings) if "text" in each.metadata]

    def decorate(command: F) -> F:
        @wraps(command)
        def collected(*arguments: Any, **given: Any) -> Any:
            values = {each.name: given.pop(engine_settings.spelling(each)) for each in known}
            found = {name: value for name, value in values.items() if value is not None}
            return command(*arguments, **{argument: make(**found)}, **given)

        decorated: Any = collected
        for each in reversed(known):
            decorated = _option(each, **other.get(each.name, {}))(decorated)
        return cast("F", decorated)

    return decorate


def _option(
    each: Field[Any], default: str | None = None, choices: Sequence[Any] = ()
) -> Callable[[F], F]:
    """Return the option of a field; with choices, it shows its default unless its text does."""
    text, choices = each.metadata["text"], choices or each.metadata["choices"]
    number = click.IntRange(each.metadata["least"]) if each.type == int | None else None
    is_shown = choices and "[default" not in text
    return click.option(
        f"{engine_settings.flag(each)}/--no-{engine_settings.spelling(each)}"
        if each.type is bool
        else engine_settings.flag(each),
        type=OneOf(choices) if choices else number or KINDS.get(each.type),
        default=None,
        metavar=each.metadata["metavar"] or None,
        show_default=(default or each.default) if is_shown else None,
        help=text,
    )


def engine_options(*, default: str = REFERENCE, sides: Sequence[str] = SIDES) -> Callable[[F], F]:
    """Give a command the options of the engine; ``engine`` has the fields that they give."""
    return options(
        "engine", EngineSettings, dict, name={"default": default}, side={"choices": sides}
    )


worker_options = options("workers", Workers, Workers)
"""Gives a command the options of the workers; it receives them as ``workers``."""

OF_ENGINE = {
    engine_settings.spelling(each) for kind in (EngineSettings, Workers) for each in fields(kind)
}
"""Parameters of commands that give the engine and its workers."""

OF_BUS = OF_ENGINE - {"engine", "workers", "dask"}
"""Those that concern a bus."""


@dataclass(frozen=True, slots=True)
class FlightFiles:
    """Files to write of a flight; ``None`` for those that are not wanted."""

    log: Path | None = option(None, "Write robots, wrong beliefs and events of each tick.", "FILE")
    trace: Path | None = option(None, "Write belief and truth of each tick as CSV.", "FILE")
    mcap: Path | None = option(None, "Write the flight as a bag for Foxglove or RViz.", "FILE")
    html: Path | None = option(None, "Write the flight as a page that plays it.", "FILE")
    gif: Path | None = option(None, "Write the flight as an animated picture.", "FILE")

    @property
    def wanted(self) -> tuple[Path, ...]:
        """The files to write."""
        return tuple(path for path in astuple(self) if path is not None)


recording_options = options("files", FlightFiles, FlightFiles)
"""Gives a command the options for files of a flight; it receives them as ``files``."""
