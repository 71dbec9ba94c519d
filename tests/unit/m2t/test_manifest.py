"""The manifest as text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from m2t.emit import FileRecord, dumps, loads
from mrsfi_runtime.errors import GenerationError

WORDS = st.text(st.characters(exclude_characters="/\\", exclude_categories=["Cs"]), min_size=1)
RECORDS = st.builds(FileRecord, WORDS, st.dictionaries(WORDS, WORDS, max_size=3))
FILES = st.dictionaries(WORDS.filter(lambda name: name not in {".", ".."}), RECORDS, max_size=3)


@given(st.dictionaries(WORDS, WORDS, max_size=3), FILES)
def test_what_a_manifest_remembers_survives_a_round_trip(sources, files):
    read = loads(dumps(sources, files), "m")

    assert read == files


def test_text_does_not_depend_on_the_order_of_entries():
    first = dumps({"a": "x", "b": "y"}, {})

    assert first == dumps({"b": "y", "a": "x"}, {})
    assert first.endswith("}\n")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"schema": 1}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": []}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": {"a.py": {"skeleton": "x"}}}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": {"a.py": [{"regions": {}}]}}',
        '{"schema": "one", "generator": "1", "sources": {}, "files": {}}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": {"../a.py": null}}',
        "[" * 100_000,
    ],
)
def test_what_is_no_manifest_is_refused(text):
    with pytest.raises(GenerationError):
        loads(text, "g/manifest.json")


def test_manifest_of_a_newer_version_is_refused(refused):
    text = dumps({}, {}).replace('"schema": 1', '"schema": 2')

    with refused(GenerationError):
        loads(text, "m")
