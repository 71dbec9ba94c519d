"""A new project of a team: a folder ready for git, with a mission that flies."""

import re
import shutil
from pathlib import Path

from m2t.classes.generator import class_files, write_classes
from m2t.generate import generate
from m2t.importing.importer import import_published
from m2t.metamodels import load_metamodels, metamodel_folder
from mrsfi.folders import find_mission
from mrsfi.found_node import node_table, topics_of
from mrsfi.versions import installed_version
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import whole_folder
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.project_file import SETTINGS

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


def start(
    name: str, source: str | None = None, published: Path | None = None, node: str | None = None
) -> Path:
    """Make the folder of a new project with a mission of its name, whole or not at all; return it.

    It begins with a mission that has a name or folder, or with a published model of the paper's
    prototype, in place of a small one. If ``node`` is the URL of a rosbridge server, ``mrsfi.toml``
    says what a node there hears and says, as far as its topics tell.
    """
    if not _NAME.fullmatch(name):
        raise UsageError(
            f"found the name '{name}'; expected letters, digits and _, a letter first, because it "
            "becomes part of Python's names"
        )
    folder = Path(name)
    begun_from = None if source is None else find_mission(source).models.resolve()
    with whole_folder(folder) as new:
        if folder.exists():
            raise UsageError(f"{folder}: exists; expected a name that is free here")
        _fill(new, name, begun_from, published)
        if node is not None:
            mission = load_code(new / "generated" / name).mission
            with (new / SETTINGS).open("a", encoding="utf-8", newline="\n") as settings:
                settings.write(f"\n{node_table(topics_of(node), mission)}")
    return folder


def _fill(folder: Path, mission: str, source: Path | None, published: Path | None) -> None:
    models = folder / "models" / mission
    for name, place in _PLACES.items():
        _write(_TEMPLATE / name, folder / place, mission)
    _copy(metamodel_folder(), folder / "metamodels", "*")
    if published is not None:
        import_published(published, models)
    elif source is not None:
        _copy(source, models, *_MODELS)
    else:
        for name in _MISSION:
            _write(_TEMPLATE / "mission" / name, models / name, mission)
    generate(models, folder / "generated" / mission)
    write_classes(folder / "generated" / "metamodel", class_files(load_metamodels().packages))


def _copy(source: Path, target: Path, *patterns: str) -> None:
    for path in sorted(path for pattern in patterns for path in source.rglob(pattern)):
        if path.is_file():
            copy = target / path.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, copy)


def _write(template: Path, place: Path, name: str) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    text = template.read_text(encoding="utf-8").replace("@name@", name)
    text = text.replace("@version@", installed_version("mrsfi"))
    place.write_text(text, encoding="utf-8", newline="\n")
