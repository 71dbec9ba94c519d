"""The words of what a person reads: printed text, docstrings, the page, and the documentation.

``PHRASES`` are words of our own for what the field has a word for; the glossary has those that are
needed. Code spans, keys and blocks of code are left aside.
"""

import ast
import re
import statistics
from pathlib import Path

import pytest

from tests.support.tree import ROOT

PHRASES = (
    *("at work", "ways? to break", "ways? more", "mildest forms?", "came back", "comes? back"),
    *("unseen", "weather", "somebody else", "hangs? on", "what flies", "who flies"),
    *("only believed broken", "the CI notices", "how sure", r"tells of", r"told of", "for good"),
    *("shares? of forms", "forms? tried", "of the forms", "nothing is known of", "nothing but"),
)
BANNED = re.compile(rf"\b(?:{'|'.join(PHRASES)})\b", re.IGNORECASE)

PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for pattern in ("README.md", "CONTRIBUTING.md", "docs/**/*.md", "examples/*/README.md")
    for path in ROOT.glob(pattern)
)
LISTS = ("docs/glossary.md",)
"""Pages that are written from values of the product."""

VALUES = ("came back",)
"""Values of JSON, which are recorded."""

SOURCES = sorted(
    path
    for folder in ("src", "m2t")
    for suffix in ("py", "js", "html")
    for path in (ROOT / folder).rglob(f"*.{suffix}")
    if path.name != "uPlot.js"
)


def prose(page: str) -> str:
    """Return a page in Markdown without blocks, code spans, and the addresses of links."""
    page = re.sub(r"^( *)```.*?^\1```$|<!--.*?-->", "", page, flags=re.DOTALL | re.MULTILINE)
    page = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", page)
    return re.sub(r"`[^`]*`", "CODE", page)


def sentences(page: str) -> list[str]:
    """Return the sentences of a page: tables and headings are none, an item of a list is one."""
    text = re.sub(r"^(?:\||#).*$", "\n", prose(page), flags=re.MULTILINE)
    text = re.sub(r"^ *(?:[-*]|\d+\.) ", "\n\n", text, flags=re.MULTILINE)
    parts = (part for block in re.split(r"\n\s*\n", text) for part in _parts(block))
    return [part for part in parts if len(part.split()) > 1]


def _parts(block: str) -> list[str]:
    return re.split(r"(?<=[.!?:])[*_)\"]*\s+(?=[\"(*_]*[A-Z0-9])", " ".join(block.split()))


def texts(source: Path) -> list[tuple[int, str]]:
    """Return what a source prints or says of itself: strings with a space; of the page, all."""
    content = source.read_text(encoding="utf-8")
    if source.suffix != ".py":
        return [*enumerate(content.splitlines(), 1)]
    found = (node for node in ast.walk(ast.parse(content)) if isinstance(node, ast.Constant))
    strings = [(node.lineno, node.value) for node in found if isinstance(node.value, str)]
    return [
        (line, re.sub(r"`[^`]*`", "CODE", text))
        for line, text in strings
        if " " in text and text not in VALUES
    ]


@pytest.mark.parametrize("page", PAGES)
def test_a_page_has_no_word_of_our_own_for_a_word_of_the_field(page):
    assert not BANNED.findall(" ".join(prose((ROOT / page).read_text("utf-8")).split()))


def test_no_text_of_the_product_has_a_word_of_our_own_for_a_word_of_the_field():
    found = [
        f"{source.relative_to(ROOT)}:{line}: {match[0]}"
        for source in SOURCES
        for line, text in texts(source)
        for match in BANNED.finditer(text)
    ]

    assert not found


@pytest.mark.parametrize("page", [page for page in PAGES if page not in LISTS])
def test_sentences_of_a_page_are_short(page):
    lengths = [len(each.split()) for each in sentences((ROOT / page).read_text(encoding="utf-8"))]

    assert statistics.mean(lengths) <= 18, statistics.mean(lengths)
    n_long = sum(length > 30 for length in lengths)
    assert n_long <= max(1, len(lengths) / 20), (n_long, len(lengths))


@pytest.mark.parametrize(
    ("page", "expected"),
    [
        ("One is here. Two are there.", ["One is here.", "Two are there."]),
        ("- one item\n- another item", ["one item", "another item"]),
        ("# Head of it\n\n| a b | c d |\n\nText stays.", ["Text stays."]),
        ("Run `a b c`: [see it](x.md).", ["Run CODE: see it."]),
        ("```sh\na b c\n```\n\nIt ran.", ["It ran."]),
    ],
)
def test_a_sentence_is_what_a_reader_takes_for_one(page, expected):
    assert sentences(page) == expected


@pytest.mark.parametrize("text", ["a fault at work", "Ways to\nbreak", "it came back"])
def test_a_word_of_our_own_is_found(text):
    assert BANNED.search(" ".join(text.split()))
