"""How a team's own node is started, reached and waited for."""

import hashlib
import json
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.cosimulation.node.mapping import NodeMapping
from mrsfi_runtime.cosimulation.node.pace import ANSWER, BARRIER, PACES
from mrsfi_runtime.cosimulation.node.reach import out_of_reach
from mrsfi_runtime.cosimulation.node.speech import Speech
from mrsfi_runtime.errors import RecordError, UsageError
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission

RESTART, SERVICE = "restart", "service"
RESETS = (RESTART, SERVICE)
"""How a node gets back to before tick 0: started anew, or by a service of its own."""

_WORDS = {
    "mapping": "table [node] of mrsfi.toml",
    "sha256": "SHA-256 of the files beside its command",
}

_LEFT_OUT = frozenset({"__pycache__", "node_modules"})


@dataclass(frozen=True, slots=True)
class NodeSettings:
    """What makes a node the collective intelligence.

    ``command`` starts it; without any it is somebody else's. ``mapping`` is its table as JSON,
    empty for generated topics, and ``sha256`` the hash of the files that the command is in. Of the
    ``repeats`` flights of a specification the median counts. ``left_out`` are faults that do not
    reach it.
    """

    command: str | None = None
    sha256: str = ""
    pace: str = BARRIER
    reset: str = RESTART
    mapping: str = ""
    prefix: str = ""
    repeats: int = 1
    left_out: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        command: str | None,
        table: object,
        *,
        url: str | None,
        pace: str | None = None,
        reset: str | None = None,
        prefix: str = "",
    ) -> "NodeSettings":
        """Return settings, chosen where nothing is said; what contradicts itself is refused."""
        if command is None and url is None:
            raise UsageError(
                "--side injector needs --node 'COMMAND {url}', which starts your node, or --url, "
                "the server on which it is found"
            )
        pace = pace or (BARRIER if url is None else ANSWER)
        if pace not in PACES and not _is_rate(pace):
            raise UsageError(
                f"--node-pace: found '{pace}'; expected {ANSWER}, {BARRIER}, or ticks a second"
            )
        if pace == BARRIER and url is not None:
            raise UsageError(
                f"--node-pace {BARRIER} pings the node, which a server at --url does not do for "
                f"us; expected {ANSWER}, a rate, or no --url"
            )
        if command is None and reset == RESTART:
            raise UsageError(f"--node-reset {RESTART} needs --node, which starts your node")
        return cls(
            command=command,
            sha256="" if command is None else folder_sha256(command),
            pace=pace,
            reset=reset or (SERVICE if command is None else RESTART),
            mapping="" if table is None else json.dumps(table, sort_keys=True),
            prefix=prefix,
        )

    def again(self, recorded: Mapping[str, Any]) -> Self:
        """Return these settings, which have to be those of a record; ``RecordError`` otherwise."""
        for name in ("command", "pace", "reset", "mapping", "sha256"):
            now, then = getattr(self, name), recorded.get(name, "")
            if now != then:
                raise RecordError(
                    f"this campaign was flown with another node; its {_WORDS.get(name, name)}: "
                    f"found {now!r}, recorded {then!r}; expected the same, or a new campaign"
                )
        left_out = tuple(recorded.get("left_out", ()))
        return replace(self, repeats=recorded.get("repeats", 1), left_out=left_out)

    def out_of_reach(self, mission: Mission, pool: FaultPool) -> dict[str, str]:
        """Return the faults that cannot be injected, by ID, and what each touches."""
        mapping = self.table
        types = TypeTable([Path(folder) for folder in mapping.types])
        return out_of_reach(mission, pool, Speech(mapping, mission, types))

    @property
    def is_free(self) -> bool:
        """Whether the node runs by its own clock."""
        return self.pace not in PACES

    @property
    def table(self) -> NodeMapping:
        """What the node hears and says."""
        return NodeMapping.of(json.loads(self.mapping) if self.mapping else None)


def folder_sha256(command: str) -> str:
    """Return the hash of all files beside those that a command names, and in folders below.

    What lies in the working folder itself is hashed alone: there is all of a project beside it.
    """
    sha = hashlib.sha256()
    for path in _files(command):
        sha.update(f"{path.as_posix()}\0".encode())
        sha.update(path.read_bytes())
    return sha.hexdigest()


def _files(command: str) -> Iterator[Path]:
    try:
        named = [Path(word) for word in shlex.split(command)]
    except ValueError:
        named = []
    files = [path for path in named if path.is_file() and not path.is_absolute()]
    folders = {path.parent for path in files if path.parent != Path()}
    found = {path for path in files if path.parent == Path()}
    for folder in folders:
        found |= {
            path
            for path in folder.rglob("*")
            if path.is_file() and not _LEFT_OUT & set(path.parts) and path.name[0] != "."
        }
    yield from sorted(found)


def _is_rate(text: str) -> bool:
    try:
        return 0.0 < float(text) <= 1000.0
    except ValueError:
        return False
