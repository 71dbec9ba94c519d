"""Keep a copy of every model that tests judge: a plugin, ``pytest -p tests.interop.recorder``.

The folder that MRSFI_RECORDED names receives one folder for each different model, and an index
of what was judged. Only models are kept that break nothing but constraints which are stated in
EVL: Eclipse loads the others not at all, or not as they are.
"""

import functools
import hashlib
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import m2t.load
from m2t.diagnostics import CONSTRAINTS
from m2t.load import Inspection

INDEX = "models.jsonl"
"""Name of the index: a line of JSON for each model, with its folder and what was judged in it."""

_MAX_FILES = 50
_seen: set[str] = set()


def pytest_configure() -> None:
    """Have everything recorded that is inspected from now on, before tests import it."""
    for name in ("inspect_folder", "inspect_specification"):
        setattr(m2t.load, name, _recorded(getattr(m2t.load, name)))


def _recorded(inspect: Callable[[Path], Inspection]) -> Callable[[Path], Inspection]:
    @functools.wraps(inspect)
    def recording(path: Path) -> Inspection:
        inspection = inspect(path)
        if all(CONSTRAINTS[found.constraint].evl for found in inspection.diagnostics):
            _keep(path, inspection)
        return inspection

    return recording


def _keep(path: Path, inspection: Inspection) -> None:
    """Copy the files of a model, and say which of them is what."""
    files = dict.fromkeys(_files(path, inspection))
    if not files or len(files) > _MAX_FILES:
        return
    base = Path(os.path.commonpath([file.parent for file in files]))
    contents = {file.relative_to(base).as_posix(): file.read_bytes() for file in files}
    judged = _place(path, base)
    key = hashlib.sha256(repr((judged, sorted(contents.items()))).encode()).hexdigest()
    if key in _seen:
        return
    _seen.add(key)
    recorded = Path(os.environ["MRSFI_RECORDED"])
    folder = recorded / str(len(_seen))
    for name, content in contents.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    with (recorded / INDEX).open("a", encoding="utf-8") as index:
        test = os.environ.get("PYTEST_CURRENT_TEST", "").partition(" ")[0]
        entry = {"folder": folder.name, "judged": judged, "test": test}
        index.write(f"{json.dumps(entry)}\n")


def _files(path: Path, inspection: Inspection) -> Iterator[Path]:
    """Yield the files of a model: those that were loaded, and those beside them."""
    folder = path if path.is_dir() else path.parent
    for file in sorted(folder.rglob("*.xmi")):
        if file.is_file() and not file.is_symlink():
            yield file.resolve()
    if path.is_file():
        yield path.resolve()
    if inspection.draft is not None:
        for loaded in inspection.draft.files:
            yield loaded.path.resolve()


def _place(path: Path, base: Path) -> str:
    return Path(os.path.relpath(path.resolve(), base)).as_posix()
