"""Namespaces as Eclipse reads them; ``tests/interop/test_emf_forms.py`` asks Eclipse itself."""

import re

import pytest

from m2t.models.load import inspect_folder, load_mission_folder, saved
from tests.support.models.copies import MISSION, MODELS

TEXT = (MODELS / MISSION).read_text(encoding="ascii")
BARE = re.sub(r"<(/?)mission:", r"<\1", TEXT).replace("xmlns:mission=", "xmlns=")
SPELLINGS = {
    "default namespace": BARE.replace('xsi:type="mission:', 'xsi:type="'),
    "xmi:type": TEXT.replace("xsi:type", "xmi:type"),
    "elements with the prefix": re.sub(r"<(/?)(robots|goals)", r"<\1mission:\2", TEXT),
}


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_a_model_in_another_spelling_is_saved_in_the_usual_one(spelling, folder):
    (folder / MISSION).write_text(SPELLINGS[spelling], encoding="ascii")

    contents = saved(load_mission_folder(folder))

    assert contents[folder / MISSION].decode("ascii") == TEXT


def test_an_element_of_another_namespace_is_refused_with_it(folder, approved):
    text = TEXT.replace("<obstacles", '<x:obstacles xmlns:x="http://other"', 1)
    (folder / MISSION).write_text(text.replace("</obstacles", "</x:obstacles", 1), "ascii")

    found = inspect_folder(folder).diagnostics[0]

    assert found.constraint == "KnownFeature"
    approved(found.message)


def test_a_type_whose_prefix_is_not_declared_is_refused_with_what_would_be_found(folder, approved):
    (folder / MISSION).write_text(BARE, encoding="ascii")

    found = inspect_folder(folder).diagnostics[0]

    assert found.constraint == "ConcreteType"
    approved(found.message)
