"""The page of constraints says of each what the code does."""

import ast
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from m2t.models.fixes import FIXES
from m2t.read import WARNINGS
from tests.support.broken_models import BROKEN
from tests.support.constraints import LISTED, REASONS

M2T = Path(__file__).parents[2] / "m2t"


NODES = [
    node
    for path in M2T.rglob("*.py")
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
]
PLACES = {"add": 1, "_add": 1, "Defect": 0, "Range": 0}
"""Where calls such as ``report.add(node, "NoText", …)`` name a constraint."""


def _reported() -> Iterator[str]:
    for call in NODES:
        if isinstance(call, ast.Call):
            place = PLACES.get(ast.unparse(call.func).rpartition(".")[2], len(call.args))
            for each in call.args[place : place + 1]:
                if isinstance(each, ast.Constant) and isinstance(each.value, str):
                    yield each.value


def test_the_page_lists_what_is_reported_and_nothing_else():
    reported = {*_reported()} - {"dropped", "default", "inconsistent", "renamed"}  # kinds of notes
    texts = {node.value for node in NODES if isinstance(node, ast.Constant)}

    assert reported | {entry.constraint for entry in BROKEN} <= {*LISTED} <= texts


def test_severities_and_fixes_are_those_of_the_code():
    warnings = [name for name, each in LISTED.items() if each.severity == "warning"]
    fixes = {name: each.fix for name, each in LISTED.items() if each.fix}

    assert sorted(warnings) == sorted(WARNINGS)
    assert {each.severity for each in LISTED.values()} == {"error", "warning"}
    assert fixes == {name: fix.title for name, fix in FIXES.items()}


def test_every_constraint_is_stated_in_evl_or_has_a_reason_not_to_be():
    unstated = [name for name, each in LISTED.items() if each.evl == "none"]

    assert sorted(unstated) == sorted(chain.from_iterable(REASONS.values()))
