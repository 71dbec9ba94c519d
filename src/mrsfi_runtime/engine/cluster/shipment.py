"""What travels to a worker, which may be on another machine, in an empty folder."""

import pickle
import platform
import sys
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib import metadata
from pathlib import Path
from typing import Self

import mrsfi_runtime
from mrsfi_runtime.imported_copies import copied_files
from mrsfi_runtime.model.faults import FaultPool

_ELSEWHERE = frozenset({"analysis", "causes", "cli", "search", "study"})
"""Rooms of mrsfi whose source no evaluation depends on."""


@dataclass(frozen=True, slots=True)
class Shipment:
    """The generated code of a mission, and what a worker needs to fly it with the same bits.

    Its name follows from the content. ``given`` and ``absolute`` are the folder it comes from, as
    the user names it and from the root; ``environment`` is what the worker has to have.
    """

    name: str
    files: dict[str, bytes]
    pool: FaultPool | None
    given: str
    absolute: str
    environment: dict[str, str]

    @classmethod
    def of(cls, directory: Path, pool: FaultPool | None = None) -> Self:
        """Return the shipment of a folder of generated code, and of the faults to fly."""
        paths = [path for path in sorted(directory.iterdir()) if path.is_file()]
        paths += copied_files(directory)
        files = {path.relative_to(directory).as_posix(): path.read_bytes() for path in paths}
        digest = sha256(pickle.dumps(pool))
        for name, content in files.items():
            digest.update(f"{name} {len(content)}\n".encode() + content)
        return cls(
            name=f"mrsfi-{digest.hexdigest()[:16]}",
            files=files,
            pool=pool,
            given=str(directory),
            absolute=str(directory.absolute()),
            environment=environment(),
        )

    def unpack(self, folder: Path) -> None:
        """Write the files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in self.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)

    def told_as_at_home(self, text: str, folder: Path) -> str:
        """Return a message or traceback with the places of the code where it comes from."""
        framed = text.replace(f'File "{folder}', f'File "{self.absolute}')
        return framed.replace(str(folder), self.given)

    def differences(self) -> str:
        """Return what of this process is not as it has to be, for a message; empty if nothing."""
        found = environment()
        return ", ".join(
            f"{name} {found[name]} where this command has {expected}"
            for name, expected in self.environment.items()
            if found[name] != expected
        )


@cache
def environment() -> dict[str, str]:
    """Return what decides the bits of a result, and whether two processes understand each other."""
    return {
        "mrsfi": f"{_version('mrsfi')} (source {_source_hash()})",
        "Python": f"{sys.version_info.major}.{sys.version_info.minor}",
        "numba": _version("numba"),
        "distributed": _version("distributed"),
        "processor": platform.machine(),
    }


def _source_hash() -> str:
    """Return a hash of all source of mrsfi on which evaluations depend."""
    package = Path(str(mrsfi_runtime.__file__)).parent
    digest = sha256()
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] not in _ELSEWHERE:
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:8]


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
