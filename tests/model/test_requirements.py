"""Requirements from a ReqIF file: what the model of a mission gets, and what is refused."""

import shutil
from pathlib import Path
from xml.sax.saxutils import escape

import pytest
from lxml import etree

from m2t.models.load import load_mission_folder
from m2t.models.requirements import ReqifFile, model_id
from mrsfi.models import import_requirements
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import MODELS, edit

EXAMPLE = MODELS.parent / "undersea"
RICH = "<xhtml:p>In 10 s, the vehicle takes <xhtml:b>at least</xhtml:b> 20 measurements.</xhtml:p>"
PREFIXED = """<?xml version="1.0"?>
<r:REQ-IF xmlns:r="http://www.omg.org/spec/ReqIF/20110401/reqif.xsd"><r:CORE-CONTENT>
<r:REQ-IF-CONTENT><r:DATATYPES>
  <r:DATATYPE-DEFINITION-STRING IDENTIFIER="_t" LAST-CHANGE="2026-03-02T08:30:00Z" MAX-LENGTH="9"/>
</r:DATATYPES><r:SPEC-TYPES><r:SPEC-OBJECT-TYPE IDENTIFIER="_type"><r:SPEC-ATTRIBUTES>
  <r:ATTRIBUTE-DEFINITION-STRING IDENTIFIER="_d" LONG-NAME="Description"/>
</r:SPEC-ATTRIBUTES></r:SPEC-OBJECT-TYPE></r:SPEC-TYPES>
<r:SPEC-OBJECTS><r:SPEC-OBJECT IDENTIFIER="_x.7"><r:VALUES>
  <r:ATTRIBUTE-VALUE-STRING THE-VALUE="The vehicle&#xA;returns."><r:DEFINITION>
    <r:ATTRIBUTE-DEFINITION-STRING-REF>_d</r:ATTRIBUTE-DEFINITION-STRING-REF>
  </r:DEFINITION></r:ATTRIBUTE-VALUE-STRING>
</r:VALUES><r:TYPE><r:SPEC-OBJECT-TYPE-REF>_type</r:SPEC-OBJECT-TYPE-REF></r:TYPE>
</r:SPEC-OBJECT></r:SPEC-OBJECTS></r:REQ-IF-CONTENT></r:CORE-CONTENT></r:REQ-IF>
"""


@pytest.fixture
def folder(tmp_path):
    return Path(shutil.copytree(EXAMPLE, tmp_path / "models" / "undersea"))


@pytest.fixture
def reqif(folder):
    return folder / "requirements.reqif"


def texts(folder):
    return {each.ID: each.text for each in load_mission_folder(folder).mission.requirements}


def test_the_file_of_the_example_has_what_its_model_has(folder, reqif):
    before = (folder / "mission.xmi").read_bytes()

    done = import_requirements(folder, ReqifFile(reqif))

    assert done["unchanged"] == ("R1", "R2", "R3")
    assert not any(done[name] for name in ("added", "changed", "kept", "written"))
    assert (folder / "mission.xmi").read_bytes() == before


def test_requirements_are_added_changed_and_kept_and_only_their_lines_are_written(folder, reqif):
    hostile = "</script><img src=x onerror=alert(1)>, {{ 7*7 }} \"'& =1+1"
    edit(reqif, 'THE-VALUE="R3"', 'THE-VALUE="SYS/4 ä"')
    edit(reqif, "at most 120 energy units.", escape(hostile))
    before = (folder / "mission.xmi").read_text().splitlines()

    done = import_requirements(folder, ReqifFile(reqif))

    assert done["added"] == ("SYS_4_",)
    assert (done["changed"], done["unchanged"], done["kept"]) == (("R2",), ("R1",), ("R3",))
    assert texts(folder)["R2"] == f"In 10 s, the sensors use {hostile}"
    after = (folder / "mission.xmi").read_text().splitlines()
    assert sum(line not in before for line in after) == 2
    assert len(after) == len(before) + 1


@pytest.mark.parametrize(
    ("xhtml", "text"),
    [
        (
            "<xhtml:ul><xhtml:li>a</xhtml:li><xhtml:li><xhtml:i>b</xhtml:i>c</xhtml:li></xhtml:ul>",
            "a bc",
        ),
        ("a<xhtml:br/>b<!-- no --> c<xhtml:sub>2</xhtml:sub><?no?>d", "a b c2d"),
        ("&#160;x<![CDATA[<y> & z]]>\n\t", "x<y> & z"),
    ],
)
def test_rich_text_becomes_one_line(reqif, xhtml, text):
    edit(reqif, RICH, xhtml)

    assert ReqifFile(reqif).requirements[0].text == text


@pytest.mark.parametrize(
    ("own", "identity"),
    [("R1", "R1"), ("12", "R12"), ("_a1", "R_a1"), ("SYS/Ä 1", "SYS_1"), ("[REQ-7]", "R_REQ-7_")],
)
def test_an_id_of_the_tool_becomes_one_that_a_model_allows(own, identity):
    assert model_id(own) == identity


def test_values_of_other_names_and_a_prefix_are_read_by_options(tmp_path):
    path = tmp_path / "plain.reqif"
    path.write_text(PREFIXED, encoding="utf-8")

    (found,) = ReqifFile(path, "Description").requirements

    assert (found.id, found.text) == ("R_x.7", "The vehicle returns.")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<REQ-IF ", '<!DOCTYPE a [<!ENTITY b SYSTEM "/etc/passwd">]>\n<REQ-IF ', "document type"),
        ("</THE-HEADER>", "", "not well-formed"),
        ('LONG-NAME="ReqIF.Text"', 'LONG-NAME="Text"', "as --text: ReqIF.ChapterName"),
        ('THE-VALUE="R2"', 'THE-VALUE="R1"', "gets the ID 'R1', as does the one in line"),
        ('THE-VALUE="R2"', 'THE-VALUE="nautilus"', "which another element of the mission has"),
        ("In 10 s, the sensors", "x" * 2001, "a text of 2,031 characters; expected at most 2,000"),
        ('THE-VALUE="R2"', f'THE-VALUE="{"x" * 201}"', "a ID of 201 characters; expected at most"),
    ],
)
def test_a_file_that_cannot_be_used_changes_nothing(folder, reqif, old, new, message):
    edit(reqif, old, new)
    before = (folder / "mission.xmi").read_bytes()

    with pytest.raises(ModelError) as caught:
        import_requirements(folder, ReqifFile(reqif))

    assert message in str(caught.value)
    assert str(caught.value).startswith(str(reqif))
    assert (folder / "mission.xmi").read_bytes() == before


def test_another_xml_file_is_refused(folder):
    with pytest.raises(ModelError, match="is no ReqIF file; expected <REQ-IF>"):
        ReqifFile(folder / "mission.xmi")


def test_a_requirement_may_have_the_id_of_a_goal_in_another_case_and_a_name_of_python(folder):
    edit(folder / "mission.xmi", 'ID="R3"', 'ID="class"')

    assert [*texts(folder)] == ["R1", "R2", "class"]


def test_results_are_one_more_value_and_all_else_stays(reqif):
    results = {"R1": "late", "R2": "none found", "R3": "not searched"}

    written = ReqifFile(reqif).with_results(results)

    root = etree.fromstring(written)
    added = [each for each in root.iter() if "mrsfi" in f"{each.attrib}{each.findtext('*/*')}"]
    assert len(added) == 2 + len(results)
    for each in added:
        each.getparent().remove(each)
    both = (root.getroottree(), etree.parse(reqif))
    assert len({etree.tostring(each, method="c14n") for each in both}) == 1
    reqif.write_bytes(written)
    again = ReqifFile(reqif).with_results(dict.fromkeys(results, "late"))
    assert again == written.replace(b"none found", b"late").replace(b"not searched", b"late")


def test_results_keep_the_prefix_and_the_encoding_of_a_file(tmp_path):
    path = tmp_path / "plain.reqif"
    path.write_text(PREFIXED.replace('"1.0"', '"1.0" encoding="UTF-16"'), encoding="utf-16")

    written = ReqifFile(path, "Description").with_results({"R_x.7": "undetected"})

    value = '<r:ATTRIBUTE-VALUE-STRING THE-VALUE="undetected"><r:DEFINITION>'
    assert value in written.decode("utf-16")


def test_results_need_the_types_that_the_schema_requires(reqif):
    edit(reqif, 'TYPE IDENTIFIER="_requirement"', 'TYPE IDENTIFIER="_other"')

    with pytest.raises(ModelError, match="lacks the type of a requirement"):
        ReqifFile(reqif).with_results(dict.fromkeys(("R1", "R2", "R3"), "late"))
