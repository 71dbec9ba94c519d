"""The notebooks of examples/ run from their first cell to their last."""

import pytest

from tests.support.cli import ROOT, workspace
from tests.support.missing import skip

try:
    import nbformat
    from nbclient import NotebookClient
except ImportError:
    nbformat = None

NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


def test_there_are_two():
    assert len(NOTEBOOKS) == 2


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_its_tables_and_pictures(path, tmp_path):
    if nbformat is None:
        skip("nbclient, ipykernel or pandas is missing; install mrsfi[examples]")
    notebook = nbformat.read(path, as_version=4)

    there = {"metadata": {"path": workspace(tmp_path)}}
    done = NotebookClient(notebook, timeout=300, resources=there).execute()

    shown = [output for cell in done.cells for output in cell.get("outputs", ())]
    html = [each.data["text/html"] for each in shown if "text/html" in each.get("data", {})]
    assert len(html) >= 2
    assert all("<table" in each for each in html)
