"""What Epsilon and we find in the same models, and what both write when they fix them."""

import base64
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from m2t.models.fixes import FIXES, mend
from m2t.models.load import inspect_folder
from mrsfi_runtime.errors import Diagnostic
from tests.interop.eclipse import ROOT, Note, difference, harness
from tests.support.constraints import LISTED
from tests.support.models.copies import FAULTS, MISSION

EVL = ROOT / "metamodels"
TWINS = frozenset(name for name, each in LISTED.items() if each.evl != "none")

Finding = tuple[str, str, str]
"""Constraint, severity, and message without line numbers, which a loaded model has none of."""


@dataclass(frozen=True, slots=True)
class Judged:
    """A mission folder, what we find in it, and what Epsilon answers."""

    path: Path
    diagnostics: tuple[Diagnostic, ...]
    answer: Mapping[str, Any]

    @property
    def is_loaded(self) -> bool:
        """Whether Eclipse loads the model, and all of it.

        Of a list of references it drops what has a colon, as it takes that for a type; and there
        is no workspace here that could hold what ``platform:`` refers to.
        """
        fatal = ("load: ", "proxy: platform:")
        is_refused = any(error.startswith(fatal) for error in self.answer["errors"])
        return not is_refused and not any(
            found.constraint == "ResolvedReference" and _DROPPED.search(found.message)
            for found in self.diagnostics
        )

    @property
    def ours(self) -> Mapping[Finding, int]:
        """What we find, without what may have been meant, which is ours alone to say."""
        return _counted(
            (found.constraint, found.severity, _MEANT.sub("", found.message))
            for found in self.diagnostics
        )

    @property
    def theirs(self) -> Mapping[Finding, int]:
        return _counted(
            (found["constraint"], found["severity"], message)
            for found in self.answer["unsatisfied"]
            for message in found["message"].split("\n")
        )

    @property
    def fixed_by_epsilon(self) -> Mapping[Path, tuple[bytes, bytes]]:
        """What Eclipse saves before and after Epsilon's fixes, by file."""
        before, after = self.answer["before"], self.answer["after"]
        return {
            Path(name): (base64.b64decode(before[name]), base64.b64decode(after[name]))
            for name in after
        }


_MEANT = re.compile(r"; did you mean '[^']*'\?")
_PLACES = re.compile(rb' xsi:schemaLocation="[^"]*"')
_DROPPED = re.compile(r" refers to '[^'#/]*:[^'#/]*' as ")


def judged(paths: Sequence[Path]) -> list[Judged]:
    """Return what both find in models that both load and that break only what both state."""
    inspected = [(path, inspect_folder(path)) for path in paths]
    known = [
        (path, folder_files(path), inspection.diagnostics)
        for path, inspection in inspected
        if {found.constraint for found in inspection.diagnostics} <= TWINS
    ]
    answers = epsilon([files for _, files, _ in known])
    models = [
        Judged(path, diagnostics, answer)
        for (path, _, diagnostics), answer in zip(known, answers, strict=True)
    ]
    return [model for model in models if model.is_loaded]


def epsilon(models: Sequence[Sequence[Path]]) -> list[dict[str, Any]]:
    """Return what Epsilon answers about models, each a list of files."""
    files = [[str(file) for file in model] for model in models]
    answer = harness("evl", {"program": str(EVL / "faults.evl"), "models": files})
    found: list[dict[str, Any]] = answer["models"]
    return found


def folder_files(folder: Path) -> list[Path]:
    """Return the files of a mission folder that a user would open together."""
    return [path for path in (folder / MISSION, folder / FAULTS) if path.exists()]


def require_same_findings(name: str, models: Sequence[Judged], note: Note) -> set[str]:
    """Compare both, model by model; return the constraints that were found somewhere."""
    for model in models:
        assert model.theirs == model.ours, model.path
    found = {constraint for model in models for constraint, _, _ in model.ours}
    note(
        f"(c) {name}",
        models=len(models),
        constraints_compared_by_model=sum(len(model.answer["checked"]) for model in models),
        by_element=sum(sum(model.answer["checked"].values()) for model in models),
        constraints_found=len(found),
        findings=sum(sum(model.ours.values()) for model in models),
        differences=0,
    )
    return found


def require_same_fixes(models: Sequence[Judged], note: Note) -> set[str]:
    """Compare the bytes that fixes write; return the constraints that were fixed."""
    fixed: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    for model in models:
        offered = [found for found in model.answer["unsatisfied"] if found["fixes"]]
        if not offered and not any(found.constraint in FIXES for found in model.diagnostics):
            continue
        inspection = inspect_folder(model.path)
        if inspection.draft is None:
            counts["models_with_errors_of_structure_first"] += bool(offered)
            continue
        mending = mend(inspection)
        contents = {} if mending is None else mending.contents
        written = {path.resolve(): content for path, content in contents.items()}
        assert set(written) <= set(model.fixed_by_epsilon), model.path
        for path, (before, after) in model.fixed_by_epsilon.items():
            ours, theirs = map(_without_places, (written.get(path, before), after))
            assert theirs == ours, difference(path, ours, theirs)
        fixed.update(found["constraint"] for found in offered)
        counts["models"] += bool(offered)
        counts["files_written"] += len(written)
    note("(c) fixes", fixes=fixed.total(), constraints=len(fixed), **counts, differences=0)
    return set(fixed)


def _without_places(content: bytes) -> bytes:
    """Return a file without where its metamodels are, which EMF writes anew: its own are here."""
    return _PLACES.sub(b' xsi:schemaLocation=""', content)


def offered_fixes(models: Iterable[Judged]) -> set[tuple[str, str]]:
    """Return the fixes that Epsilon offers: constraint and title."""
    return {
        (found["constraint"], title)
        for model in models
        for found in model.answer["unsatisfied"]
        for title in found["fixes"]
    }


def stated_fixes() -> set[tuple[str, str]]:
    """Return the fixes that we offer for what EVL states: constraint and title."""
    return {(name, fix.title) for name, fix in FIXES.items() if name in TWINS}


def _counted(findings: Iterable[Finding]) -> Mapping[Finding, int]:
    return Counter(
        (constraint, severity, _comparable(message)) for constraint, severity, message in findings
    )


def _comparable(message: str) -> str:
    """Return a message without line numbers, and with numbers spelt in one way."""
    message = re.sub(r" in line \d+( of [^;]+\.xmi)?| \(line \d+( of [^;]+\.xmi)?\)", "", message)
    return re.sub(r"'[-+.\dEe]*\d[-+.\dEe]*'", _spelt, message)


def _spelt(match: re.Match[str]) -> str:
    try:
        return repr(float(match[0][1:-1]))
    except ValueError:
        return match[0]
