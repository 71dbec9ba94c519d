from pathlib import Path

import pytest

from docs.glossary import glossary_page
from mrsfi_runtime.glossary import TERMS

PAGE = Path(__file__).parents[2] / "docs" / "glossary.md"


def test_the_page_lists_all_terms_as_they_are():
    assert PAGE.read_text(encoding="utf-8") == glossary_page()


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.name)
def test_a_term_is_explained_in_one_sentence_with_an_example_and_a_term_of_the_field(term):
    assert term.meaning.endswith(".")
    assert ". " not in term.meaning
    assert term.example
    assert term.neighbour


def test_a_term_is_listed_once():
    assert len({term.name for term in TERMS}) == len(TERMS)
