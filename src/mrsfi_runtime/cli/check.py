"""The command ``mrsfi check``: flies what is kept, and fails where a weakness came back."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import click
from rich.table import Table

from mrsfi.folders import find_mission
from mrsfi.regressions import Checked, check_all, missions_with_kept
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.engines import EngineOptions
from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.errors import LimitExceeded, UsageError
from mrsfi_runtime.files import whole_file
from mrsfi_runtime.record.measure import NONE

_CAME_BACK, _UNKNOWN, _HOLDS = "came back", "cannot be judged", "holds"
_NO_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What stands in no file of XML: control characters, halves of characters."""


def check(
    mission: str | None,
    generated: Path | None,
    *,
    engine: EngineOptions,
    n_seeds: int | None,
    junit: Path | None,
    is_json: bool,
) -> None:
    """Fly everything that is kept, and say what came back."""
    if mission is None and generated is not None:
        raise click.UsageError("--generated needs MISSION")
    settings = engine.settings(default=AUTO)
    places = [*missions_with_kept()] if mission is None else [find_mission(mission, generated)]
    if not places:
        raise UsageError(
            "found nothing that is kept in models/*/regressions/; expected at least one weakness; "
            "keep one with: mrsfi keep CAMPAIGN --weakness 1"
        )
    found = {each.name: [*check_all(each, settings, tell, n_seeds)] for each in places}
    if junit is not None:
        with whole_file(junit) as file:
            file.write(_junit(found))
        tell(f"written    {junit}")
    if is_json:
        print_json({name: [*map(_as_json, checked)] for name, checked in found.items()})
    else:
        for name, checked in found.items():
            _print(name, checked)
    _end(found)


def _end(found: Mapping[str, Sequence[Checked]]) -> None:
    """Raise what the command ends with: what came back, or else what fails first on the way."""
    every = [each for checked in found.values() for each in checked]
    failures = [each.failure for each in every if each.failure is not None]
    unknown = f"; {len(failures)} cannot be judged" if failures else ""
    back = [each.excess for each in every if each.exceeded]
    if back:
        raise LimitExceeded(f"came back: {'; '.join(back)}{unknown}")
    if failures:
        raise min(failures, key=lambda error: error.exit_code)


def _print(name: str, checked: Sequence[Checked]) -> None:
    judged = [each for each in checked if each.counts]
    title = f"{name}: {sum(_state(each) == _HOLDS for each in checked)} of {len(checked)} hold"
    if judged:
        n_kept = _range(len(each.regression.mission_seeds) for each in judged)
        n_flown = _range(len(each.seeds) for each in judged)
        title += f" (mission seeds: limits of {n_kept}, flown in {n_flown})"
    print_table(title, _table(checked))
    failed: dict[str, list[str]] = defaultdict(list)
    for each in checked:
        if each.gone:
            gone = ", ".join(each.gone)
            click.echo(f"{each.regression.name}: not in the pool: {gone} (flown as kept)\n")
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


def _table(checked: Sequence[Checked]) -> Table:
    return plain_table(
        ("kept", "counted", "goal"), ("at most", "now"), _rows(checked), ("verdict",)
    )


def _rows(checked: Sequence[Checked]) -> Iterator[tuple[object, ...]]:
    """Yield a row for each goal that has something, or may."""
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


def _state(each: Checked) -> str:
    if each.exceeded:
        return _CAME_BACK
    return _HOLDS if each.failure is None else _UNKNOWN


def _as_json(each: Checked) -> dict[str, Any]:
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
    }


def _junit(found: Mapping[str, Sequence[Checked]]) -> bytes:
    """Return what became of everything as the XML that build servers read of JUnit."""
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
    text: bytes = ET.tostring(root, "utf-8", xml_declaration=True)
    return text + b"\n"


def _legal(text: str) -> str:
    """Return a text with escapes in the place of what XML has no character for."""
    return _NO_XML.sub(lambda found: ascii(found[0])[1:-1], text)
