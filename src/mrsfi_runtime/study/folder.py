"""The folder of a comparison: a campaign for each run, and what is concluded from them."""

import json
from collections.abc import Mapping
from dataclasses import astuple
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any, Self

from mrsfi_runtime.analysis.plots import rendered
from mrsfi_runtime.analysis.tables import Cell, Table, as_csv
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.files import write_atomically
from mrsfi_runtime.record.database import CampaignFolder
from mrsfi_runtime.study.comparison import Comparison, finite
from mrsfi_runtime.study.plots import illustrate
from mrsfi_runtime.study.variants import Value


class ComparisonFolder(CampaignFolder):
    """Layout of the folder, which has lock and figures where a campaign's has them."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.runs = path / "runs"
        self.summary = path / "comparison.json"

    @classmethod
    def reserve(cls, path: Path) -> Self:
        """Take the folder of a comparison, or make a new one."""
        folder = cls(path)
        if not (folder.runs.is_dir() and folder.lock.is_file()):
            return super().reserve(path)
        if any(folder.runs.glob("*.json")):
            raise RecordError(
                f"{path}: found a comparison of an earlier mrsfi, whose runs are no campaigns; "
                "expected one of this mrsfi; compare in another folder with --out, or remove this "
                "one"
            )
        return folder

    def run(self, algorithm: str, seed: int) -> CampaignFolder:
        """Return the folder of a run."""
        return CampaignFolder(self.runs / f"{algorithm}-{seed}")

    def write(self, comparison: Comparison, content: Mapping[str, Any]) -> None:
        """Write tables, figures and summary; those of before are replaced."""
        text = f"{json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)}\n"
        try:
            tables = {"runs": _runs, "quartiles": _quartiles, "tests": _tests}
            if comparison.sweep is not None:
                tables["settings"] = setting_table
            for name, table in tables.items():
                write_atomically(self.path / f"{name}.csv", as_csv(table(comparison).lines))
            self.figures.mkdir(exist_ok=True)
            for name, figure in illustrate(comparison):
                for suffix, drawn in rendered(figure).items():
                    write_atomically(self.figures / f"{name}{suffix}", drawn)
            write_atomically(self.summary, text.encode())
        except OSError as error:
            raise RecordError(
                f"{self.path}: cannot be written: {error.strerror or error}; expected a folder "
                "that can be, on a disk with some room; runs that are finished stay"
            ) from error


def _runs(comparison: Comparison) -> Table:
    """Return one row for each run with all measures; what was never reached is empty."""
    told, criteria = ("algorithm", "seed", "n_evaluations", "n_failures"), comparison.criteria
    rows = (
        (*attrgetter(*told)(run), *(finite(each.value(run)) for each in criteria), run.digest)
        for run in comparison.runs
    )
    columns = (*told, *(criterion.name for criterion in criteria), "digest")
    return Table("Runs", columns, rows)


def _quartiles(comparison: Comparison) -> Table:
    rows = (
        (measure, name, len(comparison.of(name)), *map(finite, astuple(found)))
        for measure, by_algorithm in comparison.quartiles.items()
        for name, found in by_algorithm.items()
    )
    columns = ("measure", "algorithm", "n_runs", "lower", "median", "upper")
    return Table("Quartiles", columns, rows)


def _tests(comparison: Comparison) -> Table:
    names = ("measure", "first", "second", "u", "p_value", "holm_p_value", "method", "a12")
    columns = (*names, "magnitude")
    return Table(
        "Tests", columns, [itemgetter(*columns)(test.as_json()) for test in comparison.tests]
    )


def setting_table(comparison: Comparison) -> Table:
    """Return the settings of a sweep, each compared with the paper's by best fitness."""
    assert comparison.sweep is not None
    tests = {test.first: test for test in comparison.tests if test.measure == "fitness"}

    def row(name: str, values: Mapping[str, Value]) -> tuple[Cell, ...]:
        median = comparison.quartiles["fitness"][name].median
        cells = (*values.values(), len(comparison.of(name)), median)
        if name not in tests:
            return (*cells, None, None, None, "the paper's")
        found = tests[name]
        return (*cells, found.ranks.a12, found.holm_p_value, found.ranks.magnitude, found.verdict)

    told = ("n_runs", "median", "a12", "holm_p_value", "magnitude", "verdict")
    rows = [row(name, values) for name, values in comparison.sweep.settings().items()]
    return Table("Settings", (*comparison.sweep.values, *told), rows, ("magnitude", "verdict"))
