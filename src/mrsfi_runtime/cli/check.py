"""The command ``mrsfi check``: flies what is kept, and fails where a finding came back."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import click
from rich.table import Table

from mrsfi.folders import find_mission, missions
from mrsfi.regressions import Checked, check_all
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.engines import EngineOptions
from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.errors import LimitExceeded, UsageError
from mrsfi_runtime.files import whole_file
from mrsfi_runtime.record.measure import NONE
from mrsfi_runtime.record.regressions import kept

_CAME_BACK, _NOT_FLOWN, _HOLDS = "came back", "not flown", "holds"


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
    names = [mission] if mission is not None else _with_findings()
    found = {}
    for name in names:
        folders = find_mission(name, generated)
        found[folders.name] = [*check_all(folders, settings, tell, n_seeds)]
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


def _with_findings() -> list[str]:
    names = [folders.name for folders in missions() if kept(folders.models)]
    if not names:
        raise UsageError(
            "found nothing that is kept in models/*/regressions/; expected at least one finding; "
            "keep one with: mrsfi keep CAMPAIGN --finding 1"
        )
    return names


def _end(found: Mapping[str, Sequence[Checked]]) -> None:
    """Raise what the command ends with: first what came back, then what could not be flown."""
    every = [each for checked in found.values() for each in checked]
    back = [each.excess for each in every if each.exceeded]
    if back:
        raise LimitExceeded(f"came back: {'; '.join(back)}")
    for each in every:
        if each.error is not None:
            raise each.error


def _print(name: str, checked: Sequence[Checked]) -> None:
    title = f"{name}: {sum(_state(each) == _HOLDS for each in checked)} of {len(checked)} hold"
    print_table(title, _table(checked))
    for each in checked:
        if each.gone:
            gone = ", ".join(each.gone)
            click.echo(f"{each.regression.name}: not in the pool: {gone} (flown as kept)\n")
        if each.error is not None:
            click.echo(f"{each.regression.name}: {each.error}\n")
        if each.exceeded:
            click.echo(f"{each.regression.name} came back. Found in {each.regression.found}")
            click.echo("\n".join(f"  {sentence}" for sentence in each.why) + "\n")


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
            yield (*head, NONE, NONE, NONE, _NOT_FLOWN)
            continue
        counts = ((goal, regression.limits[goal], now) for goal, now in each.counts.items())
        for goal, most, now in [row for row in counts if any(row[1:])] or [(NONE, 0, 0)]:
            yield (*head, goal, most, now, _HOLDS if now <= most else _CAME_BACK)
            head = ("", "")


def _state(each: Checked) -> str:
    if each.error is not None:
        return _NOT_FLOWN
    return _CAME_BACK if each.exceeded else _HOLDS


def _as_json(each: Checked) -> dict[str, Any]:
    regression = each.regression
    return {
        "name": regression.name,
        "state": _state(each),
        "violations": regression.violations,
        "mission_seeds": list(regression.mission_seeds),
        "max": dict(regression.limits),
        "now": each.counts,
        "exceeded": list(each.exceeded),
        "error": None if each.error is None else str(each.error),
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
            errors=str(sum(_state(each) == _NOT_FLOWN for each in checked)),
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
            if each.error is not None:
                ET.SubElement(case, "error", message=str(each.error))
            elif each.exceeded:
                failure = ET.SubElement(case, "failure", message=each.excess)
                failure.text = "\n".join((f"Found in {each.regression.found}", *each.why))
    ET.indent(root)
    text: bytes = ET.tostring(root, "utf-8", xml_declaration=True)
    return text + b"\n"
