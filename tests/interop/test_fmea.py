"""The workbook of an FMEA, read by LibreOffice: each text is a text, each figure as in the CSV."""

import csv
import io
import shutil
import subprocess

import pytest

from mrsfi_runtime.analysis.documents import FMEA, HEADS, fmea
from mrsfi_runtime.errors import printable
from tests.unit.analysis.test_failure_modes import ALL, EMPTY


def test_libreoffice_reads_the_texts_and_figures_that_went_into_it(tmp_path):
    command = shutil.which("soffice")
    if command is None:
        pytest.skip("LibreOffice is not installed; in make test, python-calamine reads the same")
    modes = [EMPTY | {"item": text, "status": text, "S": 9, "likelihood": 0.02} for text in ALL]
    (tmp_path / "fmea.xlsx").write_bytes(FMEA[".xlsx"](fmea("m", modes)))
    profile = f"-env:UserInstallation={(tmp_path / 'profile').as_uri()}"
    as_csv = ("--convert-to", "csv:Text - txt - csv (StarCalc):44,34,76", "--outdir", tmp_path)

    subprocess.run(
        [command, profile, "--headless", *as_csv, tmp_path / "fmea.xlsx"],
        capture_output=True,
        check=True,
        timeout=300,
    )

    written = (tmp_path / "fmea.csv").read_text(encoding="utf-8")
    head, *rows = csv.reader(io.StringIO(written, newline=""))
    assert head == [*HEADS]
    read = [{name: cell for name, cell in zip(HEADS, row, strict=True) if cell} for row in rows]
    figures = {"weakness": "7", "S": "9", "likelihood": "0.02", "most ticks": "3"}
    assert read == [{"item": each, "status": each} | figures for each in map(printable, ALL)]
