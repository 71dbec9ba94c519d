"""What a campaign runs on: mission, engine, versions, and the hash of every file it copied."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Self

from mrsfi_runtime.model.semantics import SEMANTICS

BOTH, CI, INJECTOR = "both", "ci", "injector"
"""Sides that a campaign ran: simulation and collective intelligence, the latter alone, or what is
between a simulation and a team's own node."""


@dataclass(frozen=True, slots=True)
class EngineRecord:
    """The engine that a campaign was flown by."""

    name: str = ""  # of a record that does not say
    url: str | None = None  # of the rosbridge server, without its token; embedded if none
    ros: int | None = None  # version of ROS that it speaks; none without a bus
    client: str | None = None  # kind of roslibpy's connection; none without a bus
    side: str = BOTH
    is_bundled: bool = False  # whether all messages of a tick travelled as one
    world_prefix: str = ""  # of the topics of the simulation
    timeout: float | None = None  # seconds for which the other side may be silent, if not as usual
    node: Mapping[str, Any] | None = None  # a team's own node, as engine.node_settings has it
    unrepeated: str = ""  # how it was seen not to repeat itself, if it was

    @property
    def is_foreign(self) -> bool:
        """Whether the simulation or the collective intelligence was somebody else's."""
        return self.side != BOTH

    @property
    def parts(self) -> str:
        """Which parts were external, in words; flights of other parts are no repetition."""
        if self.side == CI:
            return "an external simulation"
        if self.side == INJECTOR:
            return "an external node" if self.url is None else "an external node and simulation"
        return "mrsfi's own simulation and the generated code"

    @property
    def left_out(self) -> tuple[str, ...]:
        """Faults of the pool that could not be injected into the node."""
        return tuple((self.node or {}).get("left_out", ()))

    def as_json(self) -> dict[str, Any]:
        """Return the entries of a manifest."""
        told = {"engine": self.name} | ({"unrepeated": self.unrepeated} if self.unrepeated else {})
        if self.client is None:
            return told
        unusual = {
            "bundle": self.is_bundled,
            "ros": None if self.ros == 1 else self.ros,
            "world_prefix": self.world_prefix,
            "timeout": self.timeout,
            "node": self.node,
        }
        bus = {key: value for key, value in unusual.items() if value}
        return {**told, "bus": {"url": self.url, "client": self.client, "side": self.side, **bus}}

    @classmethod
    def from_json(cls, manifest: Mapping[str, Any]) -> Self:
        """Return what the entries of a manifest say."""
        bus = {"ros": 1} | manifest["bus"] if "bus" in manifest else {}
        told = {each.name: bus[each.name] for each in fields(cls) if each.name in bus}
        told["is_bundled"] = bool(bus.get("bundle", False))
        return cls(manifest.get("engine", ""), unrepeated=manifest.get("unrepeated", ""), **told)


@dataclass(frozen=True, slots=True)
class Manifest:
    """What a campaign runs on."""

    mission: str = ""
    place: str = ""  # of its models from the project's root on, if the name does not say it
    case: str = ""  # campaign file, as the command line named it
    engine: EngineRecord = field(default_factory=EngineRecord)
    versions: Mapping[str, str] = field(default_factory=dict)  # what decides what is found
    machine: str = ""  # kind of processor
    sha256: Mapping[str, str] = field(default_factory=dict)  # of every copied file, by name
    semantics: int = SEMANTICS  # version of the world's rules

    def as_json(self) -> dict[str, Any]:
        """Return the manifest as values of JSON."""
        return {
            "mission": self.mission,
            "place": self.place,
            "case": self.case,
            **self.engine.as_json(),
            "versions": self.versions,
            "machine": self.machine,
            "sha256": self.sha256,
            "semantics": self.semantics,
        }

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Self:
        """Return the manifest that ``as_json`` described; what is missing is empty."""
        known = {each.name: values[each.name] for each in fields(cls) if each.name in values}
        engine = EngineRecord.from_json(values)
        return cls(**{**known, "engine": engine})
