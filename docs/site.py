"""Pages of the site beside those of docs/: the README and others of the tree, and a reference.

mkdocs calls the functions of this file. A page may link to files of the tree; on the site, such a
link leads to the page of that file, or to a copy of it.
"""

import posixpath
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from m2t.metaclasses import features
from m2t.metamodels import load_metamodels
from mrsfi_runtime.cli.main import cli, help_text
from mrsfi_runtime.project_file import installed_version

ROOT = Path(__file__).parent.parent
SOURCES = "tree"
"""Folder of the site with copies of files of the tree that pages link to."""

PUBLIC = (
    *("mrsfi.mission.load", "mrsfi.mission.Mission", "mrsfi.flight.Flight"),
    *("mrsfi.campaign.Campaign", "mrsfi.models.write_models", "mrsfi.regressions.regression_test"),
    *("mrsfi_runtime.model.faults.TimedFault", "mrsfi_runtime.model.mission.Outcome"),
    "mrsfi_runtime.errors",
)
_GENMODEL = "http://www.eclipse.org/emf/2002/GenModel"
_LINK = re.compile(r"\[(?P<text>[^\]]*)\]\((?![a-z]+:|#)(?P<path>[^)#\s]+)(?P<rest>[^)]*)\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages of the tree's root, examples and results of benchmarks, and the reference."""
    texts = {
        "reference/commands.md": _commands(),
        "reference/metamodels.md": _metamodels(),
        "reference/python.md": _python(),
    }
    pages = ("*.md", "examples/*/README.md", "benchmarks/results/*.md")
    for path in (path for pattern in pages for path in ROOT.glob(pattern)):
        texts[_page_of(path)] = path.read_text(encoding="utf-8")
    for name, text in texts.items():
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Let links to files of the tree lead to what the site has of them."""
    here = _place_of(page.file.src_uri)

    def led(found: re.Match[str]) -> str:
        path = (here.parent / found["path"]).resolve()
        path = path / "README.md" if (path / "README.md").is_file() else path
        if path.is_dir():
            return found["text"]
        if not path.exists():
            return found[0]  # mkdocs says that it leads nowhere
        name = posixpath.relpath(
            _kept(path, files, config), posixpath.dirname(page.file.src_uri) or "."
        )
        return f"[{found['text']}]({name}{found['rest']})"

    return _LINK.sub(led, markdown)


def _kept(path: Path, files: Files, config: MkDocsConfig) -> str:
    """Return where the site has a file of the tree; a copy is added if it has none."""
    name = _page_of(path)
    if files.get_file_from_path(name) is None:
        files.append(File.generated(config, name, abs_src_path=str(path)))
    return name


def _page_of(path: Path) -> str:
    """Return the name that the site has for a file of the tree."""
    name = path.relative_to(ROOT).as_posix()
    if name == "README.md":
        return "index.md"
    if name.startswith("docs/"):
        return name.removeprefix("docs/")
    return name if name.endswith(".md") else f"{SOURCES}/{name}"


def _place_of(name: str) -> Path:
    """Return the file of the tree that a page of the site comes from."""
    if name == "index.md":
        return ROOT / "README.md"
    return ROOT / "docs" / name if (ROOT / "docs" / name).exists() else ROOT / name


def _commands() -> str:
    """Return the help of every command, as it prints it."""
    parts = ["# Commands\n"]
    context = click.Context(cli, info_name="mrsfi")
    parts.append(f"```text\n{cli.get_help(context)}\n```\n")
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command is not None
        text = command.get_help(click.Context(command, info_name=name, parent=context))
        parts.append(f"## mrsfi {name}\n\n```text\n{text}\n```\n")
    parts.append(f"## mrsfi help bus\n\n```text\n{help_text(context, 'bus')}\n```\n")
    return "\n".join(parts)


def _python() -> str:
    """Return the page of the Python API, whose text are the docstrings."""
    named = "\n\n".join(f"::: {name}" for name in PUBLIC)
    return (
        f"# Python API\n\nmrsfi {installed_version('mrsfi')}. `import mrsfi` has these names; "
        f"[the API by example](../api.md) shows their use.\n\n{named}\n"
    )


def _metamodels() -> str:
    """Return the page of the metamodels, whose text is their documentation."""
    head = (
        "What `mission.ecore` and `faults.ecore` say. A class has the features of those it extends."
    )
    parts = [f"# Metamodels\n\n{head}\n"]
    for package in load_metamodels().packages:
        parts.append(f"## {package.name}.ecore\n\nNamespace `{package.nsURI}`\n")
        parts += [text for each in package.eClassifiers for text in _classifier(each)]
    return "\n".join(parts)


def _classifier(classifier: Any) -> Iterator[str]:
    kind = classifier.eClass.name
    if kind == "EEnum":
        yield f"### {classifier.name}\n\n{_documented(classifier)}\n"
        rows = [(f"`{each.name}`", _documented(each)) for each in classifier.eLiterals]
        yield _table(("literal", "meaning"), rows)
    elif kind == "EClass":
        parents = ", ".join(f"`{parent.name}`" for parent in classifier.eSuperTypes)
        abstract = "abstract" if classifier.abstract else ""
        said = "; ".join(filter(None, (abstract, parents and f"extends {parents}")))
        yield f"### {classifier.name}\n\n{_documented(classifier)}{f' ({said})' if said else ''}\n"
        own = [each for each in features(classifier) if each.eContainingClass is classifier]
        if own:
            yield _table(("feature", "type", "how many", "meaning"), map(_feature, own))


def _feature(feature: Any) -> tuple[str, ...]:
    most = "*" if feature.many else "1"
    contained = "contains " if getattr(feature, "containment", False) else ""
    return (
        f"`{feature.name}`",
        f"{contained}`{feature.eType.name}`",
        f"{feature.lowerBound} … {most}",
        _documented(feature),
    )


def _documented(element: Any) -> str:
    annotation = element.getEAnnotation(_GENMODEL)
    return "" if annotation is None else str(annotation.details.get("documentation", ""))


def _table(head: tuple[str, ...], rows: Any) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
