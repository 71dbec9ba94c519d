"""The report for a paper, set by pdfLaTeX."""

import shutil
import subprocess

import pytest

from mrsfi_runtime.analysis.documents import FMEA, HEADS, LATEX_HEAD, fmea, in_latex, to_latex
from mrsfi_runtime.analysis.tables import Table
from tests.integration.analysis.test_page import HOSTILE
from tests.support.cli import mrsfi
from tests.support.missing import skip
from tests.support.rendezvous import NAME, write_rendezvous

LETTERS = "".join(map(chr, (*range(0x20, 0x250), *range(0x2000, 0x2300)))) + "αβЖ日😀\N{BOM}"
SPECIAL = ["\\input{/etc/passwd}", "100 % & $x_1^2$ #{~}", "\\end{document}", "a\nb", "[", "]"]


def set_by_latex(folder, name):
    """Return what pdfLaTeX says of a file, which it has to set without an error."""
    command = shutil.which("pdflatex")
    if command is None:
        skip("pdflatex is not installed")
    done = subprocess.run(
        [command, "-interaction=nonstopmode", "-no-shell-escape", name],
        cwd=folder,
        capture_output=True,
        check=False,
        timeout=300,
    )
    said = done.stdout.decode(errors="replace")
    assert done.returncode == 0, [line for line in said.splitlines() if line.startswith("!")]
    assert (folder / name).with_suffix(".pdf").read_bytes().startswith(b"%PDF-")
    return said


def test_a_report_is_set_with_all_its_figures(tmp_path):
    write_rendezvous(tmp_path)
    (tmp_path / "cover.toml").write_text("[search]\n", encoding="utf-8")
    search = ("--case", "cover.toml", "--algorithm", "cover", "--evaluations", "60")
    mrsfi("evolve", NAME, *search, "--engine", "reference", "--out", "runs/a", cwd=tmp_path)
    mrsfi("report", "runs/a", "--format", "latex", cwd=tmp_path)

    said = set_by_latex(tmp_path / "runs" / "a", "report.tex")

    figures = sorted(path.name for path in (tmp_path / "runs/a/figures").glob("*.pdf"))
    assert figures
    assert all(figure in said.replace("\n", "") for figure in figures)
    assert "Overfull" not in said
    assert "undefined" not in said


@pytest.mark.parametrize("texts", [HOSTILE[:-1], SPECIAL, [LETTERS[i::40] for i in range(40)]])
def test_any_text_is_set(texts, tmp_path):
    table = Table(in_latex("title"), ("a", "b"), [(text, 1.0) for text in texts], ("a",))
    (tmp_path / "all.tex").write_text(
        f"{LATEX_HEAD}{to_latex(table)}\\end{{document}}\n", encoding="utf-8"
    )

    set_by_latex(tmp_path, "all.tex")


def test_an_fmea_of_any_texts_is_set(tmp_path):
    modes = [dict.fromkeys(HEADS, text) for text in (*HOSTILE[:-1], *SPECIAL)]
    (tmp_path / "fmea.tex").write_bytes(FMEA[".tex"](fmea(SPECIAL[0], modes)))

    set_by_latex(tmp_path, "fmea.tex")
