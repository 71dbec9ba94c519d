"""A new project of a team: a folder ready for git, with a mission that flies."""

import re
import shutil
from pathlib import Path

from m2t.classes.generator import class_files, write_classes
from m2t.generate import generate
from m2t.importing.importer import import_published
from m2t.metamodels import load_metamodels, metamodel_folder
from mrsfi.folders import find_mission
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import whole_folder

_TEMPLATE = Path(__file__).parent / "template"
_PLACES = {
    "Makefile": "Makefile",
    "README.md": "README.md",
    "github.yml": ".github/workflows/mrsfi.yml",
    "gitignore": ".gitignore",
    "gitlab.yml": ".gitlab-ci.yml",
    "mrsfi.toml": "mrsfi.toml",
}
_MISSION = ("build.py", "case_a.toml", "faults.xmi", "mission.xmi")
_MODELS = ("*.xmi", "*.toml")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def start(name: str, source: str | None = None, published: Path | None = None) -> Path:
    """Make the folder of a new project, and return it.

    Parameters
    ----------
    name
        Of the folder, and of its mission.
    source
        Name or folder of a mission that it begins with, in place of a small one.
    published
        A model of the paper's prototype that it begins with.

    Raises
    ------
    UsageError
        If the name cannot be one, something stands there, or there is no such mission.
    ModelError
        If the published model cannot be used.
    """
    if not _NAME.fullmatch(name):
        raise UsageError(
            f"found the name '{name}'; expected letters, digits and _, a letter first, because it "
            "becomes part of Python's names"
        )
    folder = Path(name)
    if folder.exists():
        raise UsageError(f"{folder}: exists; expected a name that is free here")
    begun_from = None if source is None else find_mission(source).models.resolve()
    with whole_folder(folder) as new:
        _fill(new, name, begun_from, published)
    return folder


def _fill(folder: Path, mission: str, source: Path | None, published: Path | None) -> None:
    models = folder / "models" / mission
    for name, place in _PLACES.items():
        _write(_TEMPLATE / name, folder / place, mission)
    shutil.copytree(metamodel_folder(), folder / "metamodels")
    if published is not None:
        import_published(published, models)
    elif source is not None:
        for pattern in _MODELS:
            for path in sorted(source.rglob(pattern)):
                copy = models / path.relative_to(source)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(path, copy)
    else:
        for name in _MISSION:
            _write(_TEMPLATE / "mission" / name, models / name, mission)
    generate(models, folder / "generated" / mission)
    write_classes(folder / "generated" / "metamodel", class_files(load_metamodels().packages))


def _write(template: Path, place: Path, name: str) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    text = template.read_text(encoding="utf-8").replace("@name@", name)
    place.write_text(text, encoding="utf-8", newline="\n")
