"""The options that choose an engine and say how its two sides meet."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import click

from mrsfi_runtime.cli.options import F, options_as
from mrsfi_runtime.engine.settings import ENGINES, REFERENCE, ROSBRIDGE, EngineSettings
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.hosting.waiting import Patience
from mrsfi_runtime.record.manifest import BOTH, CI, EngineRecord
from mrsfi_runtime.transport.rosbridge import CLIENTS, Client, without_token

SIMULATION = "simulation"
BUS_OPTIONS = ("url", "client", "side", "bundle", "timeout")


@dataclass(frozen=True, slots=True)
class EngineOptions:
    """What the command line says of the engine; ``None`` where it says nothing."""

    engine: str | None = None
    url: str | None = None
    client: str | None = None
    side: str | None = None
    timeout: float | None = None
    bundle: bool | None = None

    def settings(
        self, recorded: EngineRecord | None = None, default: str = REFERENCE
    ) -> EngineSettings:
        """Return the settings, those of a record where the command line says nothing.

        Parameters
        ----------
        recorded
            What ``recorded_engine`` returned, if anything.
        default
            Engine where neither names one.

        Raises
        ------
        UsageError
            If the options make no sense together.
        """
        recorded = recorded or EngineRecord()
        name = self.engine or recorded.name or default
        self._require_sense(name)
        bus = recorded if name == ROSBRIDGE else EngineRecord()
        side = self.side or bus.side
        url = self.url or bus.url
        if recorded.is_foreign and (name != ROSBRIDGE or side != CI):
            raise UsageError(
                "this campaign was flown on somebody else's simulation; expected the same again: "
                f"--engine {ROSBRIDGE} --side {CI} --url URL, or none of them"
            )
        if side != BOTH and url is None:
            raise UsageError(f"--side {side} needs --url: the server on which the sides meet")
        return EngineSettings(
            name=name,
            url=url,
            client=cast("Client", self.client or bus.client or CLIENTS[0]),
            has_simulation=side != CI,
            is_bundled=bus.is_bundled if self.bundle is None else self.bundle,
            patience=Patience() if self.timeout is None else Patience(tick=self.timeout),
        )

    def _require_sense(self, name: str) -> None:
        given = [option for option in BUS_OPTIONS if getattr(self, option) is not None]
        if name != ROSBRIDGE and given:
            raise UsageError(
                f"--{given[0]} needs --engine {ROSBRIDGE}; the {name} engine has no bus"
            )


def recorded_engine(settings: EngineSettings) -> EngineRecord:
    """Return what a campaign records of its engine."""
    if settings.name != ROSBRIDGE:
        return EngineRecord(settings.name)
    return EngineRecord(
        settings.name,
        url=None if settings.url is None else without_token(settings.url),
        client=settings.client,
        side=BOTH if settings.has_simulation else CI,
        is_bundled=settings.is_bundled,
    )


def engine_options(*sides: str, default: str = REFERENCE) -> Callable[[F], F]:
    """Give a command the options of the engine; it receives them as ``engine``.

    Parameters
    ----------
    sides
        Choices of --side.
    default
        The engine without --engine.
    """
    options = (
        click.option(
            "--engine",
            type=click.Choice(ENGINES),
            show_default=default,
            help="How to fly: in this process, compiled or not, or on a rosbridge server.",
        ),
        click.option(
            "--url",
            metavar="ws://…",
            help="With --engine rosbridge: the server [default: one is embedded].",
        ),
        click.option(
            "--client",
            type=click.Choice(CLIENTS),
            show_default=CLIENTS[0],
            help="With --engine rosbridge: kind of roslibpy's connection.",
        ),
        click.option(
            "--side",
            type=click.Choice(sides),
            show_default=BOTH,
            help="With --url: what this command runs; ci leaves the simulation to others.",
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
    )
    return options_as("engine", EngineOptions, options)
