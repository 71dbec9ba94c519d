"""A team's Epsilon code runs over our models, and EGL's protected regions are ours."""

from pathlib import Path

import pytest

from m2t.emit import Region, merge, parse, record_of
from mrsfi_runtime.errors import ProtectedRegionError
from tests.interop.eclipse import ROOT, harness
from tests.support.models.copies import FAULTS, MISSION, MODELS

PROGRAMS = Path(__file__).parent / "epsilon"
OURS = ROOT / "generated" / MODELS.name / "collective_intelligence.py"
NAME = "goals.py"
BODY = """    # by hand: größer, 深海 \t
    if ci.tick > 3:

        return True
    return False
"""


def _egl(target: Path) -> str:
    """Generate a file by EGL, merged with what stands there, and return it."""
    request = {
        "program": str(PROGRAMS / "goals.egl"),
        "models": [str(MODELS / MISSION)],
        "target": str(target),
    }
    written = harness("egl", request)["written"]
    assert target.read_text(encoding="utf-8") == written
    return str(written)


def _edited(text: str, region: str, body: str) -> str:
    """Return a file with another body in one region."""
    document = parse(text, NAME)
    old = document.regions[region]
    return text.replace(old.text, old.begin + body + old.end)


def _bodies(text: str) -> dict[str, str]:
    return {region.id: region.body for region in parse(text, NAME).regions.values()}


def test_a_query_finds_everything_by_the_names_of_the_metamodels():
    models = [str(MODELS / MISSION), str(MODELS / FAULTS)]

    printed = harness("eol", {"program": str(PROGRAMS / "team.eol"), "models": models})["printed"]

    lines = printed.splitlines()
    assert lines[:7] == [
        "r1 LEN 5.0: GPS_POSITION PRESSURE",
        "r2 JEN 4.0: GPS_POSITION TEMPERATURE",
        "r3 KAL 4.0: GPS_POSITION DEPTH",
        "energy 264000.0",
        "g4 r2 250",
        "g5 r3 400",
        "g6 r1 500",
    ]
    assert lines[7] == "f1 ActivateSensor s2"
    assert lines[-1] == "f30 ZeroSpeed m9"
    assert len(lines) == 7 + 30


def test_regions_of_egl_are_regions_of_ours(tmp_path, note):
    text = _egl(tmp_path / NAME)

    document = parse(text, NAME)

    checks = {f"g{n}.check": f"    return ci.{task}\n" for n, task in enumerate(_tasks(), 1)}
    note("(d) regions of EGL that we read", regions=len(document.regions), differences=0)
    assert document.text == text
    assert _bodies(text) == {"imports": "", **checks, "never": "generated every time\n"}
    assert [region.id for region in document.regions.values() if not region.is_on] == ["never"]


def _tasks() -> list[str]:
    return ["AvoidCollision", "StayWithinMissionArea", "SufficientEnergy", *["GatherSamples"] * 3]


def test_egl_and_we_merge_hand_written_code_into_the_same_text(tmp_path):
    target = tmp_path / NAME
    generated = _egl(target)
    by_hand = _edited(_edited(generated, "g4.check", BODY), "imports", "import math\n")
    target.write_text(by_hand, encoding="utf-8")

    merged = _egl(target)

    record = record_of(parse(generated, NAME))
    assert merged == by_hand
    assert merge(parse(generated, NAME), parse(by_hand, NAME), record) == merged


def test_egl_keeps_hand_written_code_of_a_file_that_we_generated(tmp_path, note):
    target = tmp_path / NAME
    ours = OURS.read_text(encoding="utf-8")
    kept = [name for name in _bodies(ours) if name == "imports" or name.endswith(".check")]
    for name in kept:
        ours = _edited(ours, name, f"# {name}\n{BODY}")
    target.write_text(ours, encoding="utf-8")

    merged = _bodies(_egl(target))

    survived = sum(merged[name] == f"# {name}\n{BODY}" for name in kept)
    note("(d) our regions that EGL keeps", regions=len(kept), differences=len(kept) - survived)
    assert len(kept) == 7
    assert survived == len(kept)


def test_our_markers_are_written_as_egl_writes_them():
    """EGL's own spelling, checked above, is ``# protected region ID on begin`` and ``end``."""
    for path in OURS.parent.glob("*.py"):
        for part in parse(path.read_text(encoding="utf-8"), path.name).parts:
            if isinstance(part, Region):
                assert part.begin.strip() == f"# protected region {part.id} on begin"
                assert part.end.strip() == f"# protected region {part.id} end"


@pytest.mark.parametrize(
    ("region", "renamed"), [("never", "never"), ("g4.check", "g44.check")], ids=["off", "orphan"]
)
def test_egl_loses_code_where_we_refuse(region, renamed, tmp_path):
    target = tmp_path / NAME
    generated = _egl(target)
    by_hand = _edited(generated, region, BODY).replace(f"region {region} ", f"region {renamed} ")
    target.write_text(by_hand, encoding="utf-8")

    assert _egl(target) == generated

    record = record_of(parse(generated, NAME))
    with pytest.raises(ProtectedRegionError, match=f"'{renamed}'"):
        merge(parse(generated, NAME), parse(by_hand, NAME), record)
