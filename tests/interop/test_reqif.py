"""Requirements of a campaign in ReqIF: its schema allows them, and another program reads them."""

import subprocess
import sys
from importlib.util import find_spec

import pytest

from tests.support.cli import mrsfi, mrsfi_json
from tests.support.missing import skip
from tests.support.models.copies import edit
from tests.support.rendezvous import NAME, write_rendezvous
from tests.support.tree import ROOT

EXAMPLE = ROOT / "models" / "undersea" / "requirements.reqif"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A project with a campaign on a mission whose first goal stands for R1 of the example."""
    if find_spec("reqif") is None:
        skip("reqif is missing; pip install -e '.[interop]'")
    place = tmp_path_factory.mktemp("reqif")
    write_rendezvous(place)
    edit(place / "models" / NAME / "mission.xmi", 'ID="g1"', 'ID="g1" requirements="R1"')
    required = '<requirements ID="R1" text="Robot a arrives in time."/>\n  <goals '
    edit(place / "models" / NAME / "mission.xmi", "<goals ", required)
    (place / "c.toml").write_text("[search]\nalgorithm = 'cover'\n", encoding="utf-8")
    mrsfi("generate", NAME, cwd=place)
    size = ("--evaluations", "60", "--engine", "reference", "--workers", "1")
    mrsfi("evolve", NAME, "--case", "c.toml", *size, "--out", "runs/it", cwd=place)
    return place


def test_results_are_valid_by_the_schema_and_read_by_another_program(place):
    from reqif.parser import ReqIFParser

    words = ("requirements", EXAMPLE, "runs/it", "--output", "out.reqif")
    lines = mrsfi(*words, cwd=place).stdout.splitlines()
    told = {line[:12].strip(): line[12:].strip().split(", ") for line in lines}

    words = [sys.executable, "-c", "from reqif.cli.main import main; main()", "validate"]
    words += ["--use-reqif-schema", str(place / "out.reqif")]
    done = subprocess.run(words, capture_output=True, check=False, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    content = ReqIFParser.parse(str(place / "out.reqif")).core_content.req_if_content
    read = {}
    for each in content.spec_objects:
        values = {value.definition_ref: value.value for value in each.attributes}
        read[values["_a-id"]] = values.get("mrsfi-result-_requirement")
    assert read.pop("1") is None  # a heading
    assert {
        name: value for value, names in told.items() for name in names if "." not in name
    } == read
    rows = mrsfi_json("weaknesses", "runs/it", "--goal", "g1", cwd=place)
    worst = {each["detection"]["worst"] for each in rows if each["measure"] != "believed"}
    gravest = "undetected" if "never" in worst else "late" if "late" in worst else "in time"
    assert worst
    assert read == {"R1": gravest, "R2": "not searched", "R3": "not searched"}
