"""The worlds of ``examples/worlds`` as modules of a test, and as programs."""

import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from tests.support.missing import skip
from tests.support.tree import ROOT

WORLDS = ROOT / "examples" / "worlds"


@contextmanager
def forgotten() -> Iterator[None]:
    """Forget at the end which modules of worlds were imported, and where they were found."""
    path, before = [*sys.path], {*sys.modules}
    try:
        yield
    finally:
        sys.path[:] = path
        for name, module in [*sys.modules.items()]:
            file = getattr(module, "__file__", None) or ""
            if name not in before and file.startswith(str(WORLDS)):
                del sys.modules[name]


def loaded(world: str, name: str = "world", library: str = "numpy") -> ModuleType:
    """Import a module of a world; without its library, skip the test."""
    if importlib.util.find_spec(library) is None:
        skip(f"{library} is missing; pip install -e '.[examples]'")
    sys.path[:0] = [str(WORLDS / world), str(WORLDS)]
    file = WORLDS / world / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"{world}_{name}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def started(
    world: str, url: str, *options: str | Path, mission: str = "uuv_sampling"
) -> subprocess.Popen[str]:
    """Start the program of a world, and wait until it serves."""
    file = WORLDS / world / "world.py"
    told = ("--mission", ROOT / "models" / mission, "--url", url)
    program = subprocess.Popen(
        [sys.executable, file, *told, *options], stdout=subprocess.PIPE, encoding="utf-8"
    )
    assert program.stdout is not None
    assert f" serves at {url}" in program.stdout.readline()
    return program
