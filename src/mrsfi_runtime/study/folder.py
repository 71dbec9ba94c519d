"""The folder of a comparison: one file for each finished run, and what is concluded from them.

Every file appears under its name when it is whole, so that a comparison that was ended goes on
with the runs that are finished.
"""

import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import astuple
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mrsfi_runtime.analysis.plots import rendered
from mrsfi_runtime.analysis.tables import Rows, as_csv
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.folder import CampaignFolder
from mrsfi_runtime.study.comparison import Comparison, finite
from mrsfi_runtime.study.plots import illustrate
from mrsfi_runtime.study.run_results import RunResult

SCHEMA = 1
"""Version of the file of a run."""

_SCRATCH = "unfinished-"


class ComparisonFolder(CampaignFolder):
    """Layout of the folder, which has copies, lock and figures where a campaign's has them."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.runs = path / "runs"
        self.summary = path / "comparison.json"

    def run_file(self, algorithm: str, seed: int) -> Path:
        """Return the file of a run."""
        return self.runs / f"{algorithm}-{seed}.json"

    def keep(self, run: RunResult, subject: Mapping[str, Any]) -> None:
        """Keep a finished run; ``subject`` is what all of the folder have in common, as JSON."""
        content = {"schema": SCHEMA, "subject": subject, "result": run.as_json()}
        with _explained(self.path):
            _write(self.run_file(run.algorithm, run.seed), _text(content))

    def kept(self, algorithm: str, seed: int, subject: Mapping[str, Any]) -> RunResult | None:
        """Return a run that is finished, or nothing.

        A file that is damaged, of a newer version or of another subject is a ``RecordError``.
        """
        path = self.run_file(algorithm, seed)
        if not path.is_file():
            return None
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            recorded, result = dict(content["subject"]), RunResult.from_json(content["result"])
            is_ours = content["schema"] == SCHEMA and (result.algorithm, result.seed) == (
                algorithm,
                seed,
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise RecordError(_damaged(path, f"{type(error).__name__}: {error}")) from error
        if not is_ours:
            raise RecordError(_damaged(path, "another schema or run"))
        _require_same(path, recorded, subject)
        return result

    def write(self, comparison: Comparison, content: Mapping[str, Any]) -> None:
        """Write tables, figures and summary; those of before are replaced."""
        with _explained(self.path):
            for name, table in _TABLES.items():
                _write(self.path / f"{name}.csv", as_csv(table(comparison)))
            self.figures.mkdir(exist_ok=True)
            for name, figure in illustrate(comparison):
                for suffix, drawn in rendered(figure).items():
                    _write(self.figures / f"{name}{suffix}", drawn)
            _write(self.summary, _text(content))

    @contextmanager
    def scratch(self) -> Iterator[Path]:
        """Yield an empty folder that goes with the end of the body; a kill leaves it behind."""
        with _explained(self.path):
            made = TemporaryDirectory(prefix=_SCRATCH, dir=self.path)
        with made as place:
            yield Path(place)

    def tidy(self) -> None:
        """Remove what earlier processes left when they were killed."""
        for leftover in self.path.glob(f"{_SCRATCH}*"):
            shutil.rmtree(leftover, ignore_errors=True)


def _require_same(path: Path, recorded: Any, subject: Mapping[str, Any]) -> None:
    if recorded == subject:
        return
    other = sorted(
        key for key in {*recorded, *subject} if recorded.get(key, None) != subject.get(key, None)
    )
    raise RecordError(
        f"{path}: found a run with other {', '.join(other)}: {_excerpt(recorded, other)}; expected "
        f"{_excerpt(subject, other)}; compare in another folder with --out, or remove this one"
    )


def _excerpt(subject: Mapping[str, Any], keys: list[str]) -> str:
    return ", ".join(f"{key} {str(subject.get(key))[:20]}" for key in keys[:5])


def _damaged(path: Path, what: str) -> str:
    return (
        f"{path}: is not the result of a run, as `mrsfi compare` writes it ({what}); "
        "remove the file, and the run is made again"
    )


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise RecordError(
            f"{path}: cannot be written: {error.strerror or error}; expected a folder that can be, "
            "on a disk with some room; runs that are finished stay"
        ) from error


def _text(content: Mapping[str, Any]) -> bytes:
    return f"{json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)}\n".encode()


def _write(path: Path, content: bytes) -> None:
    """Write a file that appears under its name when it is whole, and on the disk."""
    new = path.with_name(f"{path.name}.new")
    try:
        with new.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        new.replace(path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def _cell(value: float | None) -> float | str:
    """Return a number as it is, and what was never reached as an empty cell."""
    return "" if value is None or finite(value) is None else value


def runs_table(comparison: Comparison) -> Rows:
    """Return one row for each run with all measures."""
    names = (criterion.name for criterion in comparison.criteria)
    rows = (
        (
            run.algorithm,
            run.seed,
            run.n_evaluations,
            run.n_failures,
            *(_cell(criterion.value(run)) for criterion in comparison.criteria),
            run.digest,
        )
        for run in comparison.runs
    )
    return [("algorithm", "seed", "n_evaluations", "n_failures", *names, "digest"), *rows]


def quartiles_table(comparison: Comparison) -> Rows:
    """Return the quartiles of every measure for every algorithm; never reached is empty."""
    rows = (
        (measure, name, len(comparison.of(name)), *map(_cell, astuple(found)))
        for measure, by_algorithm in comparison.quartiles.items()
        for name, found in by_algorithm.items()
    )
    return [("measure", "algorithm", "n_runs", "lower", "median", "upper"), *rows]


def tests_table(comparison: Comparison) -> Rows:
    """Return every test of two algorithms on a measure."""
    rows = (
        (
            test.measure,
            test.first,
            test.second,
            test.ranks.u,
            test.ranks.p_value,
            test.holm_p_value,
            test.ranks.method,
            test.ranks.a12,
            test.ranks.magnitude,
        )
        for test in comparison.tests
    )
    names = ("measure", "first", "second", "u", "p_value", "holm_p_value", "method", "a12")
    return [(*names, "magnitude"), *rows]


_TABLES: Mapping[str, Callable[[Comparison], Rows]] = {
    "runs": runs_table,
    "quartiles": quartiles_table,
    "tests": tests_table,
}
