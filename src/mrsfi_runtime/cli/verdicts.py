"""What became of kept weaknesses: printed, or as files for scripts and build servers."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from os.path import normpath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mrsfi_runtime.cli.terminal import print_table

if TYPE_CHECKING:
    from mrsfi.regressions import Checked

_CAME_BACK, _UNKNOWN, _HOLDS = "came back", "cannot be judged", "holds"
_NO_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What stands in no file of XML: control characters, halves of characters."""


def print_tables(found: "Mapping[str, Sequence[Checked]]") -> None:
    """Print verdicts by mission, and why what came back did."""
    for name, checked in found.items():
        _print(name, checked)


def print_annotations(checked: "Iterable[Checked]") -> None:
    """Print for GitHub what came back, or cannot be judged, at the lines that it is about."""
    for each in checked:
        told = f"{each.regression.name}: "
        if each.exceeded:
            told += f"{each.excess.partition(': ')[2]}. {' '.join(each.why)}"
        elif each.failure is not None:
            told += str(each.failure)
        else:
            continue
        for path, line in each.places or ((each.regression.specification, 1),):
            file = _escaped(normpath(path), ":,")
            click.echo(f"::error file={file},line={line}::{_escaped(told)}")


def _escaped(text: str, more: str = "") -> str:
    for letter in ("%", "\r", "\n", *more):
        text = text.replace(letter, f"%{ord(letter):02X}")
    return text


def _print(name: str, checked: "Sequence[Checked]") -> None:
    from mrsfi_runtime.analysis.tables import Table

    judged = [each for each in checked if each.counts]
    title = f"{name}: {sum(_state(each) == _HOLDS for each in checked)} of {len(checked)} hold"
    if judged:
        n_kept = _range(len(each.regression.mission_seeds) for each in judged)
        n_flown = _range(len(each.seeds) for each in judged)
        title += f" (mission seeds: limits of {n_kept}, flown in {n_flown})"
    words = ("kept", "counted", "goal")
    columns = (*words, "at most", "now", "verdict")
    print_table(Table(title, columns, [*_rows(checked)], words, ("verdict",)))
    failed: dict[str, list[str]] = defaultdict(list)
    for each in checked:
        if each.gone:
            gone = ", ".join(each.gone)
            click.echo(f"{each.regression.name}: not in the pool: {gone} (flown as kept)\n")
        if each.regression.accepted:
            click.echo(f"{each.regression.name}: accepted because {each.regression.accepted}\n")
        if each.exceeded:
            click.echo(f"{each.regression.name} came back. Found in {each.regression.found}")
            click.echo("\n".join(f"  {sentence}" for sentence in each.why) + "\n")
        elif each.failure is not None:
            failed[str(each.failure)].append(each.regression.name)
    for message, names in failed.items():
        click.echo(f"{', '.join(names)} cannot be judged: {message}\n")


def _range(numbers: Iterable[int]) -> str:
    """Return ``5``, or ``1 to 5``."""
    found = sorted({*numbers})
    return " to ".join(map(str, dict.fromkeys((found[0], found[-1]))))


def _rows(checked: "Sequence[Checked]") -> Iterator[tuple[str | int, ...]]:
    from mrsfi_runtime.record.store import NONE

    for each in checked:
        regression = each.regression
        head = (regression.name, regression.violations)
        if each.error is not None:
            yield (*head, NONE, NONE, NONE, _UNKNOWN)
            continue
        counts = ((goal, regression.limits[goal], now) for goal, now in each.now.items())
        for goal, most, now in [row for row in counts if any(row[1:])] or [(NONE, 0, 0)]:
            worse = _CAME_BACK if goal in each.exceeded else _UNKNOWN
            yield (*head, goal, most, now, _HOLDS if now <= most else worse)
            head = ("", "")


def _state(each: "Checked") -> str:
    if each.exceeded:
        return _CAME_BACK
    return _HOLDS if each.failure is None else _UNKNOWN


def as_json(each: "Checked") -> dict[str, Any]:
    """Return a verdict for a script."""
    regression = each.regression
    return {
        "name": regression.name,
        "state": _state(each),
        "violations": regression.violations,
        "mission_seeds": list(each.seeds),
        "kept_seeds": list(regression.mission_seeds),
        "max": dict(regression.limits),
        "now": each.now,
        "exceeded": list(each.exceeded),
        "error": None if each.failure is None else str(each.failure),
        "not_in_pool": list(each.gone),
        "why": list(each.why),
        "found": regression.found,
        "accepted": regression.accepted,
    }


def write_junit(path: Path, found: "Mapping[str, Sequence[Checked]]") -> None:
    """Write what became of everything as the XML that build servers read of JUnit."""
    from xml.etree import ElementTree as ET

    from mrsfi_runtime.files import whole_file

    root = ET.Element("testsuites")
    for name, checked in found.items():
        suite = ET.SubElement(
            root,
            "testsuite",
            name=name,
            tests=str(len(checked)),
            failures=str(sum(_state(each) == _CAME_BACK for each in checked)),
            errors=str(sum(_state(each) == _UNKNOWN for each in checked)),
            time=f"{sum(each.seconds for each in checked):.3f}",
        )
        for each in checked:
            case = ET.SubElement(
                suite,
                "testcase",
                classname=f"mrsfi.{name}",
                name=each.regression.name,
                time=f"{each.seconds:.3f}",
            )
            if each.exceeded:
                failure = ET.SubElement(case, "failure", message=each.excess)
                failure.text = "\n".join((f"Found in {each.regression.found}", *each.why))
            elif each.failure is not None:
                ET.SubElement(case, "error", message=str(each.failure))
    for element in root.iter():
        element.text = element.text and _legal(element.text)
        element.attrib.update({key: _legal(value) for key, value in element.attrib.items()})
    ET.indent(root)
    with whole_file(path) as file:
        file.write(ET.tostring(root, "utf-8", xml_declaration=True) + b"\n")


def _legal(text: str) -> str:
    """Return a text with escapes in the place of what XML has no character for."""
    return _NO_XML.sub(lambda found: ascii(found[0])[1:-1], text)
