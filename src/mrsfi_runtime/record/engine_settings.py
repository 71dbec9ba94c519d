"""The engine as one value, its workers, and the manifest of what a campaign runs on.

Each field of ``EngineSettings`` is one fact, which options, record and messages share. The command
line gives the fields that ``option`` makes: ``cli/options.py`` loops over them, ``as_json`` and
``from_json`` over all. ``mrsfi/engines.py`` merges options, record and project;
``engine/opening.py`` opens the engine. So a new option of every command that flies is a field
here, and a change in the code that acts on it. A field that makes sense without a rosbridge server
also stands in ``OF_ANY_ENGINE``.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, Field, astuple, dataclass, field, fields
from importlib.util import find_spec
from typing import Any, Self

from mrsfi_runtime.cosimulation.bus_topics import ANSWER, BARRIER, PACES, Patience
from mrsfi_runtime.errors import RecordError, UsageError, expected
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.transport.topics import CLIENTS, ROS_VERSIONS, Client, without_token

AUTO, REFERENCE, COMPILED, ROSBRIDGE = "auto", "reference", "compiled", "rosbridge"
ENGINES = (AUTO, REFERENCE, COMPILED, ROSBRIDGE)
"""Ways to evaluate a fault specification; auto is compiled where that is possible."""

BOTH, CI, INJECTOR = "both", "ci", "injector"
SIDES = (BOTH, CI, INJECTOR)
"""Sides that a campaign ran: simulation and collective intelligence, the latter alone, or what is
between a simulation and an external node."""

RESTART, SERVICE = "restart", "service"
"""How a node returns to its state before tick 0: restarted, or by its own service."""

LOCAL = "local"
"""In place of a cluster's address: processes on this machine, for this command only."""

OF_ANY_ENGINE = {"name", "unrepeated"}
"""Fields that do not belong to the engine over rosbridge alone."""

_TICK, _HANDSHAKE = astuple(Patience())
_ALWAYS_RECORDED = {"name", "url", "client", "side"}  # others where they differ from the default
_SAME_NODE = {
    "node": "command",
    "node_pace": "pace",
    "node_reset": "reset",
    "node_mapping": "table [node] of mrsfi.toml",
    "node_sha256": "SHA-256 of the files beside its command",
}


def option(
    default: Any, text: str, metavar: str = "", choices: Sequence[Any] = (), spelled: str = ""
) -> Any:
    """Return a field that an option gives: its default, and what ``--help`` prints of the option.

    Options and records spell its name as it is, or as ``spelled`` says.
    """
    metadata = {"text": text, "metavar": metavar, "choices": choices, "spelled": spelled}
    return field(default=default, metadata=metadata)


def spelling(each: Field[Any]) -> str:
    """Return how a field is spelled in options and in the record."""
    return each.metadata.get("spelled") or each.name


def flag(each: Field[Any]) -> str:
    """Return the option that gives a field."""
    return f"--{spelling(each).replace('_', '-')}"


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """The engine, one of ``ENGINES``, and how it is reached.

    Fields whose names begin with ``node`` are of an external node. ``node`` is the command that
    starts it, ``None`` if it runs already at ``url``; ``node_sha256`` the hash of the files beside
    that command; ``node_mapping`` the project's table of its topics as JSON, empty for generated
    topics. Each specification is flown ``node_repeats`` times, of which the median counts;
    ``node_left_out`` are faults that do not reach it. ``unrepeated`` says how the same flight was
    observed to differ, if it was.
    """

    name: str = option(
        REFERENCE, "Simulate in this process or over rosbridge.", choices=ENGINES, spelled="engine"
    )
    url: str | None = option(None, "The rosbridge server [default: mrsfi starts one].", "ws://…")
    _: KW_ONLY
    client: Client = option(
        CLIENTS[0], "Kind of connection: mrsfi's own, or one of roslibpy's.", choices=CLIENTS
    )
    side: str = option(
        BOTH, "Sides that mrsfi runs; ci leaves out the simulation, injector the CI.", choices=SIDES
    )
    is_bundled: bool = option(
        False, "Send all messages of a tick as one, for speed.", spelled="bundle"
    )
    ros: int = option(
        1, "Version of ROS [default: that of mrsfi.toml, or 1].", choices=ROS_VERSIONS
    )
    world_prefix: str = option("", "Prefix of all topics of your simulation.", "/PREFIX")
    timeout: float = option(
        _TICK, f"Wait this long for the other side [default: {_TICK:g}].", "SECONDS"
    )
    node: str | None = option(
        None, "Command that starts your node; mrsfi fills in {url} and {seed}.", "COMMAND"
    )
    node_sha256: str = ""
    node_pace: str = option(
        BARRIER, "What ends its tick: its message, two pings, or a clock.", "answer|barrier|RATE"
    )
    node_reset: str = option(
        RESTART, "Its reset [default: restart; service without --node].", choices=(RESTART, SERVICE)
    )
    node_mapping: str = ""
    node_prefix: str = option("", "Prefix of all topics of your node.", "/PREFIX")
    node_repeats: int = 1
    node_left_out: tuple[str, ...] = ()
    unrepeated: str = ""

    def __post_init__(self) -> None:
        if self.name not in ENGINES:
            raise UsageError(f"engine: found {self.name!r}; {expected(self.name, ENGINES)}")

    def require_sense(self) -> None:
        """Refuse fields that make no sense together."""
        if self.url is None and self.side not in {BOTH, INJECTOR}:
            raise UsageError(f"--side {self.side} needs --url, the server that both sides use")
        if self.url is None and self.world_prefix:
            raise UsageError("--world-prefix needs --url, the server of the simulation")
        if self.side == INJECTOR:
            self._require_node()

    def _require_node(self) -> None:
        if self.node is None and self.url is None:
            raise UsageError(
                "--side injector needs --node 'COMMAND {url}', which starts your node, or --url, "
                "the server that it uses"
            )
        if self.is_free and not _is_rate(self.node_pace):
            raise UsageError(
                f"--node-pace: found '{self.node_pace}'; expected {ANSWER}, {BARRIER}, or ticks "
                "per second"
            )
        if self.node_pace == BARRIER and self.url is not None:
            raise UsageError(
                f"--node-pace {BARRIER} needs the server that mrsfi starts, which pings the "
                f"node; expected {ANSWER}, a rate, or no --url"
            )
        if self.node is None and self.node_reset == RESTART:
            raise UsageError(f"--node-reset {RESTART} needs --node, which starts your node")

    def require_same_node(self, recorded: Self) -> None:
        """Refuse another node than that of a record, as a ``RecordError``."""
        for name, words in _SAME_NODE.items():
            now, then = getattr(self, name), getattr(recorded, name)
            if now != then:
                raise RecordError(
                    f"this campaign was flown with another node; its {words}: found {now!r}, "
                    f"recorded {then!r}; expected the same, or a new campaign"
                )

    @property
    def patience(self) -> Patience:
        """How long each side waits for the other."""
        return Patience(self.timeout, max(self.timeout, _HANDSHAKE))

    @property
    def words(self) -> str:
        """Which engine flies, in words."""
        return f"{self.name} engine{', your node' if self.side == INJECTOR else ''}"

    @property
    def parts(self) -> str:
        """Which parts are external, in words; flights of other parts are no repetition."""
        return parts_of(self.side, self.url)

    @property
    def is_foreign(self) -> bool:
        """Whether the simulation or the collective intelligence is external."""
        return self.side != BOTH

    @property
    def is_free(self) -> bool:
        """Whether the node runs by its own clock."""
        return self.node_pace not in PACES

    def as_json(self) -> dict[str, Any]:
        """Return the entries of a manifest, in the order of the fields; groups come last."""
        usual, found = type(self)(), dict[str, Any](bus={}, node={})
        for each in fields(self):
            group, key = _entry(each)
            value = getattr(self, each.name)
            is_usual = each.name not in _ALWAYS_RECORDED and value == getattr(usual, each.name)
            if group == "node" or not is_usual:
                found.get(group, found)[key] = value
        bus, node = found.pop("bus"), found.pop("node")
        if self.url is not None:
            bus["url"] = without_token(self.url)
        if self.side == INJECTOR:
            bus["node"] = node
        return found | ({"bus": bus} if self.name == ROSBRIDGE else {})

    @classmethod
    def from_json(cls, manifest: Mapping[str, Any]) -> Self:
        """Return the settings that the entries of a manifest describe."""
        bus = manifest.get("bus", {})
        places = {"": manifest, "bus": bus, "node": bus.get("node", {})}
        found: dict[str, Any] = {}
        for each in fields(cls):
            group, key = _entry(each)
            if key in places[group]:
                value = places[group][key]
                found[each.name] = tuple(value) if isinstance(value, list) else value
        return cls(**found)


def _entry(each: Field[Any]) -> tuple[str, str]:
    """Return where in a manifest a field stands: in the group of which entry, under which key."""
    if each.name.startswith("node"):
        return "node", "command" if each.name == "node" else each.name.removeprefix("node_")
    return "" if each.name in OF_ANY_ENGINE else "bus", spelling(each)


def parts_of(side: str, url: str | None = None) -> str:
    """Return which parts are external, in words."""
    if side == CI:
        return "an external simulation"
    if side == INJECTOR:
        return "an external node" if url is None else "an external node and simulation"
    return "mrsfi's own simulation and the generated code"


def _is_rate(text: str) -> bool:
    try:
        return 0.0 < float(text) <= 1000.0
    except ValueError:
        return False


@dataclass(frozen=True, slots=True)
class Workers:
    """The workers: processes of this machine, as many as it has processors by default.

    Or a cluster: ``dask`` is the address of its scheduler, or ``local`` for one of this machine.
    """

    number: int | None = option(
        None, "Processes that evaluate [default: one for each processor].", spelled="workers"
    )
    dask: str | None = option(
        None, "Evaluate on the dask cluster of this scheduler, or on a local one.", "tcp://…|local"
    )

    def require_sense(self, engine: EngineSettings) -> None:
        """Refuse what contradicts itself or the engine, or dask where it is missing."""
        if engine.url is not None and (self.number or 1) > 1:
            raise UsageError(
                f"--workers {self.number}: found a server at --url, whose topics belong to one "
                "flight at a time; expected --workers 1, or no --url, so that every worker "
                "starts its own server"
            )
        if self.dask is None:
            return
        require_address(self.dask)
        if engine.name == ROSBRIDGE:
            raise UsageError(
                f"--dask is not possible with --engine {ROSBRIDGE}, whose flights need a server "
                "beside them; expected another engine, or --workers"
            )
        if self.dask != LOCAL and self.number is not None:
            raise UsageError(
                f"--workers {self.number}: not possible with --dask {self.dask}, which has the "
                "workers that were started for it; leave --workers out"
            )


def require_address(text: str) -> None:
    """Refuse what is no address of a dask scheduler, and any while dask is not installed."""
    if find_spec("distributed") is None:
        raise UsageError(
            "--dask needs dask.distributed; install it with: pip install 'mrsfi[dask]'"
        )
    if text != LOCAL and not re.fullmatch(r"(tcp|tls)://.+:\d{1,5}", text):
        raise UsageError(
            f"--dask: found '{text}'; expected tcp://HOST:PORT or tls://HOST:PORT, as "
            f"`dask scheduler` prints it, or {LOCAL}"
        )


NOT_RECORDED = "not recorded"


@dataclass(frozen=True, slots=True)
class Manifest:
    """What a campaign runs on."""

    mission: str = ""
    place: str = ""  # of its models from the project's root on, if the name does not say it
    case: str = ""  # campaign file, as the command line named it
    engine: EngineSettings = field(default_factory=EngineSettings)
    versions: Mapping[str, str] = field(default_factory=dict)  # what decides what is found
    machine: str = ""  # kind of processor
    sha256: Mapping[str, str] = field(default_factory=dict)  # of every copied file, by name
    semantics: int = SEMANTICS  # version of the world's rules
    cover: int = 1  # version of the rules of ``cover``; records from before it have none
    created: str = ""  # date and time (UTC, ISO 8601); records from before it have none, as next
    commit: str = ""  # of the mission's folder in git, if git has the mission
    is_edited: bool = False  # whether models or code then differed from that commit

    @property
    def made(self) -> tuple[str, str]:
        """The day (UTC) on which the campaign began, and its commit, in words."""
        commit = f"{str(self.commit)[:12]}{', edited' if self.is_edited else ''}"
        return str(self.created)[:10] or NOT_RECORDED, commit if self.commit else NOT_RECORDED

    def as_json(self) -> dict[str, Any]:
        """Return the manifest as values of JSON."""
        found: dict[str, Any] = {}
        for each in fields(self):
            value = getattr(self, each.name)
            found |= value.as_json() if each.name == "engine" else {each.name: value}
        return found

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Self:
        """Return the manifest that ``as_json`` described; what is missing is empty."""
        known = {each.name: values[each.name] for each in fields(cls) if each.name in values}
        engine = EngineSettings.from_json(values)
        return cls(**{**known, "engine": engine})
