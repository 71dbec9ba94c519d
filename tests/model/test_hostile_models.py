"""Files that attack the reader end in a clear error; hostile but legal texts load."""

import os

import pytest

from m2t.diagnostics import Diagnostic
from m2t.models.load import (
    inspect_folder,
    inspect_specification,
    load_mission_folder,
    load_specification,
)
from m2t.read import MAX_BYTES, MAX_ELEMENTS
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import FAULTS, MISSION, edit

HOSTILE_NAME = """x"); import os; os.system("touch owned")  #\n'{{ 7 * 7 }}{% raw %}'\t<&>"""
HOSTILE_XML = (
    HOSTILE_NAME.replace("&", "&amp;")
    .replace("<", "&lt;")
    .replace('"', "&quot;")
    .replace("\n", "&#xA;")
    .replace("\t", "&#x9;")
)

BILLION_LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE lolz [<!ENTITY a "lol"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;">]>
<mission:Mission xmlns:mission="http://mrsfi.org/mission/1.0" name="&d;&d;&d;&d;" duration="1"/>
"""

EXTERNAL_ENTITY = """<?xml version="1.0"?>
<!DOCTYPE m [<!ENTITY secret SYSTEM "secret.txt">]>
<mission:Mission xmlns:mission="http://mrsfi.org/mission/1.0" name="&secret;" duration="1"/>
"""

EXTERNAL_DTD = """<?xml version="1.0"?>
<!DOCTYPE m SYSTEM "http://example.org/m.dtd">
<mission:Mission xmlns:mission="http://mrsfi.org/mission/1.0" name="m" duration="1"/>
"""


def _only(found: tuple[Diagnostic, ...]) -> Diagnostic:
    assert len(found) == 1, [str(entry) for entry in found]
    return found[0]


@pytest.mark.parametrize("text", [BILLION_LAUGHS, EXTERNAL_ENTITY, EXTERNAL_DTD])
def test_document_types_are_refused_before_their_content_is_read(tmp_path, text):
    (tmp_path / "secret.txt").write_text("swordfish", encoding="utf-8")
    (tmp_path / MISSION).write_text(text, encoding="utf-8")

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert (found.constraint, found.line) == ("NoDocumentType", 2)
    assert "swordfish" not in str(found)


@pytest.mark.parametrize(
    "text",
    ["<a>" * 100_000 + "</a>" * 100_000, f"<a>{'<b/>' * MAX_ELEMENTS}</a>"],
    ids=["deep", "long"],
)
def test_too_many_elements_are_refused(tmp_path, text, approved):
    (tmp_path / MISSION).write_text(text, encoding="utf-8")

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert found.constraint == "FileSize"
    approved(found.message)


def test_file_beyond_the_size_limit_is_refused(tmp_path, approved):
    with (tmp_path / MISSION).open("wb") as stream:
        stream.truncate(MAX_BYTES + 1)

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert found.constraint == "FileSize"
    approved(found.message)


def test_name_of_ten_megabytes_is_a_short_error(folder, approved):
    edit(folder / MISSION, 'name="LEN"', f'name="{"L" * 10_000_000}"')

    found = _only(inspect_folder(folder).diagnostics)

    assert found.constraint == "StringLength"
    approved(found.message)
    assert len(str(found)) < 500 + len(str(folder))


def test_id_and_tag_of_a_megabyte_are_short_errors(folder):
    edit(folder / MISSION, 'ID="b1"', f'ID="{"b" * 1_000_000}"')
    edit(folder / MISSION, "<servers ", f"<{'t' * 1_000_000}/><servers ")

    for found in inspect_folder(folder).diagnostics:
        assert len(str(found)) < 1000 + len(str(folder))


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x00\xff\xfe",
        b"not xml",
        b"<a>\xff</a>",
        b"<a b='1' b='2'/>",
        b"<a x:b='1'/>",
        b"<a/><b/>",
        b"<?xml version='1.0' encoding='UTF-7'?><a/>",
        b"<?xml version='1.0' encoding='rot13'?><a/>",
        b"<?xml version='1.0' encoding='gb18030'?><a/>",
        b"<a/>",
        b"<mission:Mission xmlns:mission='http://mrsfi.org/mission/1.0'/>",
        b"<mission:Robot xmlns:mission='http://mrsfi.org/mission/1.0' ID='r' name='n' speed='1'/>",
        b"<xmi:XMI xmlns:xmi='http://www.omg.org/XMI'/>",
    ],
)
def test_no_bytes_cause_anything_but_a_model_error(tmp_path, content):
    (tmp_path / MISSION).write_bytes(content)
    (tmp_path / FAULTS).write_bytes(content)

    assert inspect_folder(tmp_path).diagnostics
    assert inspect_specification(tmp_path / FAULTS).diagnostics
    with pytest.raises(ModelError):
        load_mission_folder(tmp_path)
    with pytest.raises(ModelError):
        load_specification(tmp_path / FAULTS)


@pytest.mark.parametrize(
    "value",
    ["", " ", "//", "//@robots.", "//@robots.99999999999", "//@x.0", "/1", "#", "##", "s4 "],
)
def test_no_reference_causes_anything_but_a_model_error(folder, value):
    edit(folder / MISSION, 'sensor="s6"', f'sensor="{value}"')

    with pytest.raises(ModelError, match="goals 'g5'"):
        load_mission_folder(folder)


@pytest.mark.parametrize(
    "href", ["", "#", "m4", "http://[", "file:///mission.xmi#m4", "//host/mission.xmi#m4", "%00#m4"]
)
def test_no_href_causes_anything_but_a_model_error(folder, href):
    edit(folder / FAULTS, "mission.xmi#m4", href)

    with pytest.raises(ModelError, match="faults 'f2'"):
        load_mission_folder(folder)
    with pytest.raises(ModelError, match="faults 'f2'"):
        load_specification(folder / FAULTS)


@pytest.mark.parametrize("make", [os.mkdir, os.mkfifo], ids=["folder", "pipe"])
def test_folder_or_pipe_in_place_of_a_model_is_an_error_at_once(tmp_path, make):
    make(tmp_path / MISSION)

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert found.constraint == "ReadableFile"


def test_hostile_display_names_are_legal_texts(folder):
    edit(folder / MISSION, 'name="LEN"', f'name="{HOSTILE_XML}"')
    edit(folder / FAULTS, 'name="f1"', f'name="{HOSTILE_XML}"')

    models = load_mission_folder(folder)

    assert inspect_folder(folder).diagnostics == ()
    assert models.mission.robots[0].name == HOSTILE_NAME
    assert models.faults.faults[0].name == HOSTILE_NAME


def test_hostile_id_is_an_error_on_one_line(folder):
    edit(folder / MISSION, 'ID="b1"', f'ID="{HOSTILE_XML}"')

    found = _only(inspect_folder(folder).diagnostics)

    assert found.constraint == "IdSyntax"
    assert "\n" not in str(found)
