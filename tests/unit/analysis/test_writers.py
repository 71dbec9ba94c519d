"""Hostile text in tables that are written as HTML and LaTeX is shown as text."""

import re
from html.parser import HTMLParser

import pytest

from mrsfi_runtime.analysis.documents import in_latex, to_latex
from mrsfi_runtime.analysis.tables import Table, to_html
from tests.integration.analysis.test_page import HOSTILE

SPECIAL = ["\\input{/etc/passwd}", "100 % & $x_1^2$ #{~}", "\\end{document}", "a\nb"]


class Tags(HTMLParser):
    """Names of the elements of a text, and what it shows."""

    def __init__(self, text):
        super().__init__()
        self.tags = set()
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        assert not attrs

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("text", HOSTILE + SPECIAL)
def test_no_cell_or_title_becomes_markup_in_html(text):
    found = Tags(to_html(Table(text, (text,), [(text,)], (text,))))

    assert found.tags <= {"table", "caption", "thead", "tbody", "tr", "th", "td"}
    assert text.split()[0][:10] in found.text or not text.isprintable()


@pytest.mark.parametrize("text", HOSTILE + SPECIAL)
def test_no_cell_or_title_becomes_a_command_in_latex(text):
    known = {"begin", "centering", "caption", "resizebox", "ifdim", "width", "textwidth", "else"}
    known |= {"fi", "toprule", "midrule", "bottomrule", "end"}

    written = to_latex(Table(text, (text,), [(text,)], (text,)))

    commands = {*re.findall(r"\\([A-Za-z]+)", written)}
    assert commands <= known | {
        "textbackslash",
        "textasciitilde",
        "textasciicircum",
        "textless",
        "textgreater",
    }
    assert written.count("\\begin{") == written.count("\\end{") == 2
    assert not re.search(r"(?<!\\)[#$^~]", written.replace("\\textasciicircum", ""))


def test_letters_that_mean_something_to_latex_stand_as_they_are():
    assert in_latex("a_b & 5 % of {x}") == r"a\_b \& 5 \% of \{x\}"
    assert in_latex("* [日]") == "{*} {[}{[}U+65E5]]"
    assert in_latex("\\n ~ ^") == r"\textbackslash{}n \textasciitilde{} \textasciicircum{}"
