"""What a campaign runs on: mission, engine, versions, and the hash of every file it copied."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Self

from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.record.engine_settings import EngineSettings


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
        engine = EngineSettings.from_json(values)
        return cls(**{**known, "engine": engine})
