"""Copies of what a team's code imports, which that code finds in the place of the originals.

Modules keep their names. Import statements in code beside such copies, those too that run in the
middle of a flight, see modules of these names from the copies alone; the rest of the process keeps
its own, so that campaigns with other modules of the same name may fly beside each other.
"""

import builtins
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

IMPORTED = "imported"
"""Subfolder of generated code that holds the copies."""

_OURS = ("mrsfi", "mrsfi_runtime", "mrsfi_bridge", "m2t")
_MODULES = (".py", ".so")
_IMPORT = builtins.__import__


def copied_files(directory: Path) -> list[Path]:
    """Return the copies beside a folder's generated code, in order."""
    found = sorted((directory / IMPORTED).rglob("*"))
    return [path for path in found if path.is_file() and path.parent.name != "__pycache__"]


def team_file(spec: ModuleSpec | None) -> Path | None:
    """Return the file of a module that a team wrote; none of a library, or of ours."""
    if spec is None or not spec.has_location:
        return None
    path = Path(str(spec.origin))
    is_library = {"site-packages", "dist-packages"}.intersection(path.parts)
    others = {*_OURS, *sys.stdlib_module_names}
    is_other = path.suffix not in _MODULES or spec.name.partition(".")[0] in others
    return None if is_library or is_other else path


@contextmanager
def importing(directory: Path, module: ModuleType | None = None) -> Iterator[None]:
    """Let a folder's copies, if it has any, be found by the body, and by a module from now on."""
    folder = directory.absolute() / IMPORTED
    if not folder.is_dir():
        yield
        return
    files = copied_files(directory)
    copies = _copies(folder, tuple((path.name, path.read_bytes()) for path in files))
    if module is not None:
        vars(module)["__builtins__"] = copies.builtins
    with copies.found():
        yield


@lru_cache(maxsize=32)
def _copies(folder: Path, _: tuple[tuple[str, bytes], ...]) -> "_Copies":
    """Return the copies in a folder, the same ones as long as their content is."""
    return _Copies(folder)


class _Copies(MetaPathFinder):
    """Modules that are imported from copies, under the names that the originals have."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        entries = (path for path in folder.iterdir() if path.is_dir() or path.suffix in _MODULES)
        self._tops = {path.name.partition(".")[0] for path in entries}
        self._modules: dict[str, ModuleType] = {}
        self._lock = RLock()
        self.builtins = {**vars(builtins), "__import__": self._import}

    @contextmanager
    def found(self) -> Iterator[None]:
        with self._lock:
            if self in sys.meta_path:
                yield
                return
            others = self._taken()
            sys.modules.update(self._modules)
            sys.meta_path.insert(0, self)
            try:
                yield
            finally:
                sys.meta_path.remove(self)
                self._modules = self._taken()
                sys.modules.update(others)

    def _taken(self) -> dict[str, ModuleType]:
        """Take all modules of these names out of those that are imported, and return them."""
        names = [name for name in sys.modules if name.partition(".")[0] in self._tops]
        return {name: sys.modules.pop(name) for name in names}

    def _import(
        self, name: str, scope: Any = None, local: Any = None, parts: Any = (), level: int = 0
    ) -> ModuleType:
        """Import as a statement does; one in a flight is said again and again."""
        top = (str(scope["__package__"]) if level else name).partition(".")[0]
        if top not in self._tops:
            return _IMPORT(name, scope, local, parts, level)
        module = None if level else self._modules.get(name)
        if module is not None and all(hasattr(module, part) for part in parts or ()):
            return module if parts else self._modules[top]
        with self.found():
            return _IMPORT(name, scope, local, parts, level)

    def find_spec(
        self, name: str, path: Sequence[str] | None, _: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return where a copy is; refuse what the team wrote and nothing was known of."""
        if name.partition(".")[0] not in self._tops:
            file = team_file(PathFinder.find_spec(name, path))
            if file is not None:
                raise ImportError(
                    f"found {file}, of which the campaign has no copy, because no import statement "
                    f"names '{name}'; expected one: write `import {name}` where it is needed"
                )
            return None
        place = self._folder.joinpath(*name.split("."))
        spec = PathFinder.find_spec(name, [str(place.parent)])
        if spec is not None and spec.submodule_search_locations is not None:
            spec.submodule_search_locations = [*spec.submodule_search_locations]  # and never others
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = loader = _Loader(name, str(spec.origin))
            loader.scope = self.builtins
        return spec


class _Loader(SourceFileLoader):
    """Gives a module the import statements of the copies before it runs."""

    scope: Mapping[str, Any]

    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__builtins__"] = self.scope
        super().exec_module(module)
