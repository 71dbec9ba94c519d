"""The engine as one value, its workers, and the manifest of what a campaign runs on.

Each field of ``EngineSettings`` is one fact, which options, record and messages share. The command
line gives the fields that ``option`` makes: ``cli/options.py`` loops over them, ``as_json`` and
``from_json`` over all. ``mrsfi/engines.py`` merges options, record and project;
``engine/opening.py`` opens the engine. So a new option of every command that flies is a field
here, and a change in the code that acts on it. A field that makes sense without a rosbridge server
also stands in ``OF_ANY_ENGINE``.
"""

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, Field, astuple, dataclass, field, fields
from importlib.util import find_spec
from typing import Any, Self

from mrsfi_runtime.cosimulation.bus_topics import ANSWER, BARRIER, PACES, Patience
from mrsfi_runtime.errors import RecordError, UsageError, expected
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.transport.topics import CLIENTS, ROS_VERSIONS, Client, without_token

AUTO, REFERENCE, COMPILED = "auto", "reference", "compiled"
ROSBRIDGE, ROS2 = "rosbridge", "ros2"
ENGINES = (AUTO, REFERENCE, COMPILED, ROSBRIDGE, ROS2)
"""Ways to evaluate a fault specification; auto is compiled where that is possible."""

ON_A_BUS = (ROSBRIDGE, ROS2)
"""Engines whose parts exchange ROS messages: over a rosbridge server, or over DDS."""

BOTH, CI, INJECTOR = "both", "ci", "injector"
SIDES = (BOTH, CI, INJECTOR)
"""Sides that a campaign ran: simulation and collective intelligence, the latter alone, or what is
between a simulation and an external node."""

BUILT_IN = "built-in"
"""The world, that is the simulation, is mrsfi's own, whatever is at the server."""

RESTART, SERVICE = "restart", "service"
"""How an external program returns to before tick 0: restarted, or by its own service."""

LOCAL = "local"
"""In place of a cluster's address: processes on this machine, for this command only."""

OF_ANY_ENGINE = {"name", "unrepeated"}
"""Fields that do not belong to the engine over rosbridge alone."""

_TICK, _HANDSHAKE = astuple(Patience())
_LAST_DOMAIN = 232
_LATE = "5%"
_ALWAYS_RECORDED = {"name", "url", "client", "side"}  # others where they differ from the default
_N_PROCESSORS = os.cpu_count() or 1

_SAME_NODE = {
    "node": "command",
    "node_pace": "pace",
    "node_reset": "reset",
    "node_mapping": "table [node] of mrsfi.toml",
    "node_sha256": "files",
}
_SAME_WORLD = {
    "world": "command",
    "world_reset": "reset",
    "world_sha256": "files",
}


def option(
    default: Any,
    text: str,
    metavar: str = "",
    choices: Sequence[Any] = (),
    spelled: str = "",
    least: int = 1,
) -> Any:
    """Return a field that an option gives: its default, and what ``--help`` prints of the option.

    Options and records spell its name as it is, or as ``spelled`` says. ``least`` is the least
    number of an integer without a default.
    """
    metadata = {
        "text": text,
        "metavar": metavar,
        "choices": choices,
        "spelled": spelled,
        "least": least,
    }
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
    starts it, ``None`` if it runs already at ``url``; ``node_sha256`` the files that the command
    depends on, each followed by its hash; ``node_mapping`` the project's table of its topics as
    JSON, empty for generated topics; ``node_left_out`` are faults that do not reach it. ``world``
    is the command that starts an external simulation, ``BUILT_IN``, or ``None`` for what ``side``
    and ``url`` say (``has_own_world``). Each specification is flown ``repeats`` times, of which the
    median counts. ``unrepeated`` says how the same flight was observed to differ, if it was.
    """

    name: str = option(
        REFERENCE,
        "Simulate in this process, or exchange ROS messages.",
        choices=ENGINES,
        spelled="engine",
    )
    url: str | None = option(None, "The rosbridge server [default: mrsfi starts one].", "ws://…")
    _: KW_ONLY
    domain: int | None = option(
        None, "DDS domain of your ROS 2 node [default: a free one].", "N", least=0
    )
    client: Client = option(
        CLIENTS[0], "Kind of connection: mrsfi's own, or one of roslibpy's.", choices=CLIENTS
    )
    side: str = option(
        BOTH, "Sides that mrsfi runs; ci leaves out the simulation, injector the CI.", choices=SIDES
    )
    world: str | None = option(
        None,
        "Command that starts your simulation; mrsfi fills in {url} and {seed}. "
        f"{BUILT_IN}: let mrsfi's own fly, though your node is at --url.",
        "COMMAND",
    )
    world_sha256: tuple[str, ...] = ()
    world_reset: str = option(
        SERVICE, "Its reset: by service, or restarted for each flight.", choices=(SERVICE, RESTART)
    )
    is_bundled: bool = option(
        False, "Send all messages of a tick as one, for speed.", spelled="bundle"
    )
    ros: int = option(
        1, "Version of ROS [default: that of mrsfi.toml, or 1].", choices=ROS_VERSIONS
    )
    world_prefix: str = option("", "Prefix of all topics of your simulation.", "/PREFIX")
    late: str = option(_LATE, f"Most late ticks of a flight [default: {_LATE}].", "SHARE")
    timeout: float = option(
        _TICK, f"Wait this long for the other side [default: {_TICK:g}].", "SECONDS"
    )
    node: str | None = option(
        None, "Command that starts your node; mrsfi fills in {url} and {seed}.", "COMMAND"
    )
    node_sha256: tuple[str, ...] = ()
    node_pace: str = option(
        BARRIER, "What ends its tick: its message, two pings, or a clock.", "answer|barrier|RATE"
    )
    node_reset: str = option(
        RESTART, "Its reset [default: restart; service without --node].", choices=(RESTART, SERVICE)
    )
    node_mapping: str = ""
    node_prefix: str = option("", "Prefix of all topics of your node.", "/PREFIX")
    repeats: int = 1
    node_left_out: tuple[str, ...] = ()
    unrepeated: str = ""

    def __post_init__(self) -> None:
        if self.name not in ENGINES:
            raise UsageError(f"engine: found {self.name!r}; {expected(self.name, ENGINES)}")

    def require_sense(self) -> None:
        """Refuse fields that make no sense together."""
        if self.name == ROS2:
            self._require_ros_2()
        elif self.domain is not None:
            raise UsageError(f"--domain {self.domain}: needs --engine {ROS2}")
        if self.url is None and self.side not in {BOTH, INJECTOR} and self.world_command is None:
            other = ", or --world 'COMMAND {url}', which starts your simulation"
            needs = f"--side {self.side} needs --url, the server that both sides use"
            raise UsageError(f"{needs}{other if self.side == CI else ''}")
        if self.world == BUILT_IN and self.side == CI:
            raise UsageError(
                f"--world {self.world}: not possible with --side {CI}, whose simulation is external"
            )
        if self.world_command is not None:
            self._require_world()
        self.most_late(100)
        is_inside = self.side == INJECTOR and self.has_own_world
        if self.world_prefix and self.name != ROS2 and (self.url is None or is_inside):
            other = "" if self.world is None else f", and no --world {self.world}"
            raise UsageError(f"--world-prefix needs --url, the server of the simulation{other}")
        if self.side == INJECTOR:
            self._require_node()

    def _require_ros_2(self) -> None:
        if find_spec("cyclonedds") is None:
            raise UsageError(
                f"--engine {ROS2} needs cyclonedds; install it with: pip install 'mrsfi[ros2]'"
            )
        if self.side != INJECTOR:
            raise UsageError(
                f"--engine {ROS2}: found --side {self.side}; expected --side {INJECTOR}, with your "
                "node"
            )
        for name in ("url", "is_bundled"):
            if getattr(self, name):
                other = flag(type(self).__dataclass_fields__[name])
                needs = f"which needs --engine {ROSBRIDGE}"
                raise UsageError(f"--engine {ROS2}: found {other}, {needs}")
        if self.domain is not None and not 0 <= self.domain <= _LAST_DOMAIN:
            raise UsageError(
                f"--domain: found {self.domain}; expected a DDS domain, 0 to {_LAST_DOMAIN}"
            )

    def _require_world(self) -> None:
        if self.url is not None:
            raise UsageError(
                f"--world: found --url {without_token(self.url)}, too; expected one of them, "
                "because a simulation that mrsfi starts has a server of its own"
            )
        if self.side not in {CI, INJECTOR}:
            raise UsageError(
                f"--side {self.side}: found --world, which replaces mrsfi's own simulation; "
                f"expected --side {CI}, {INJECTOR}, or none"
            )

    def most_late(self, duration: int) -> int:
        """Return how many ticks of a flight may be late."""
        number = self.late.removesuffix("%")
        percent = float(number) if re.fullmatch(r"\d{1,3}(\.\d+)?", number) else -1.0
        if not (0.0 <= percent <= 100.0 and self.late.endswith("%")):
            raise UsageError(f"--late: found '{self.late}'; expected a share such as {_LATE}")
        return int(percent * duration / 100.0)

    def _require_node(self) -> None:
        if self.node is None and self.url is None and self.domain is None:
            place, what = (
                ("url", "the server") if self.name != ROS2 else ("domain", "the DDS domain")
            )
            raise UsageError(
                f"--side injector needs --node 'COMMAND {{{place}}}', which starts your node, or "
                f"--{place}, {what} that it uses"
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

    def require_same_parts(self, recorded: Self) -> None:
        """Refuse another node or simulation than that of a record, as a ``RecordError``."""
        for what, same in (("node", _SAME_NODE), ("simulation", _SAME_WORLD)):
            for name, words in same.items():
                now, then = getattr(self, name), getattr(recorded, name)
                are_files = isinstance(now, tuple)
                if now == then or (are_files and isinstance(then, str)):
                    continue  # mrsfi 0.3 recorded one hash for all files
                differ = f": found {now!r}, recorded {then!r}"
                if are_files:
                    names = {each.rpartition(" ")[0] for each in {*now} ^ {*then}}
                    differ = f" have changed, or are new or gone: {', '.join(sorted(names))}"
                raise RecordError(
                    f"this campaign was flown with another {what}; its {words}{differ}; expected "
                    "the same, or a new campaign"
                )

    @property
    def patience(self) -> Patience:
        """How long each side waits for the other."""
        return Patience(self.timeout, max(self.timeout, _HANDSHAKE))

    @property
    def words(self) -> str:
        """Which engine flies, in words."""
        simulation = "" if self.has_own_world else ", your simulation"
        return f"{self.name} engine{simulation}{', your node' if self.side == INJECTOR else ''}"

    @property
    def parts(self) -> str:
        """Which parts are external, in words; flights of other parts are no repetition."""
        return parts_of(self.side, has_own_world=self.has_own_world)

    @property
    def has_own_world(self) -> bool:
        """Whether the simulation is mrsfi's own; else it is started here, or at ``url``."""
        by_default = self.side == BOTH or (self.side == INJECTOR and self.url is None)
        by_default &= self.name != ROS2 or not self.world_prefix
        return by_default if self.world is None else self.world == BUILT_IN

    @property
    def world_command(self) -> str | None:
        """The command that starts an external simulation, if there is one."""
        return None if self.world == BUILT_IN else self.world

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
        return found | ({"bus": bus} if self.name in ON_A_BUS else {})

    @classmethod
    def from_json(cls, manifest: Mapping[str, Any]) -> Self:
        """Return the settings that the entries of a manifest describe."""
        bus = manifest.get("bus", {})
        places = {"": manifest, "bus": bus, "node": bus.get("node", {})}
        found: dict[str, Any] = {}
        for each in fields(cls):
            group, key = _entry(each)
            if key == "repeats" and key in places["node"]:  # where older records have it
                group = "node"
            if key in places[group]:
                value = places[group][key]
                found[each.name] = tuple(value) if isinstance(value, list) else value
        return cls(**found)


def _entry(each: Field[Any]) -> tuple[str, str]:
    """Return where in a manifest a field stands: in the group of which entry, under which key."""
    if each.name.startswith("node"):
        return "node", "command" if each.name == "node" else each.name.removeprefix("node_")
    return "" if each.name in OF_ANY_ENGINE else "bus", spelling(each)


def parts_of(side: str, *, has_own_world: bool = True) -> str:
    """Return which parts are external, in words."""
    if side == CI:
        return "an external simulation"
    if side == INJECTOR:
        return "an external node" if has_own_world else "an external node and simulation"
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

    def count(self, engine: EngineSettings) -> int:
        """Return how many processes of this machine, or cluster, evaluate with an engine."""
        is_one = engine.url is not None or engine.domain is not None
        return self.number or (1 if is_one else _N_PROCESSORS)

    def require_sense(self, engine: EngineSettings) -> None:
        """Refuse what contradicts itself or the engine, or dask where it is missing."""
        place = "url" if engine.url is not None else "domain"
        if getattr(engine, place) is not None and (self.number or 1) > 1:
            raise UsageError(
                f"--workers {self.number}: found --{place}, whose topics belong to one flight at a "
                f"time; expected --workers 1, or no --{place}, so that every worker has its own"
            )
        if self.dask is None:
            return
        require_address(self.dask)
        if engine.name in ON_A_BUS:
            raise UsageError(
                f"--dask is not possible with --engine {engine.name}, whose flights need a server "
                "or a node beside them; expected another engine, or --workers"
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
