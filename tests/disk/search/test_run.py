"""Records that are interrupted, and functions that users bring."""

import contextlib
import sys
from collections.abc import Iterator, Sequence
from itertools import count
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from mrsfi_runtime.errors import SpecificationError, UsageError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated, FailedFlight
from mrsfi_runtime.record import database
from mrsfi_runtime.record import store as record_store
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search import run as search_run
from mrsfi_runtime.search.fitness import chosen
from mrsfi_runtime.search.run import require_settings, run_campaign
from tests.support.campaigns import store_of
from tests.support.search import evaluate_stand_in, paper_mission, pool_of, stand_in_outcome
from tests.tiers import slow

FILES = {str(each.__file__) for each in (search_run, record_store, database, contextlib)}
SETTINGS = CampaignSettings(algorithm="random", population=2, generations=1, faults=2)
CLOCK = (0, 1, 2, 3, 50, 51, *range(52, 99))
"""Lets the first result be written, then three together, and leaves the others for the end."""
MODULE = """
NUMBER = 7


def kept(space, specification, rng, share):
    return specification


def overlapping(space, specification, rng, share):
    return (*specification, *specification)


def broken(*args):
    return 1 / 0


def first_goal(findings):
    return float(findings.violations[0])


def worst_first(individuals, n_selected, rng):
    return sorted(individuals, key=lambda i: i.score.fitness)[:1] * n_selected


def nobody(individuals, n_selected, rng):
    return None


def strangers(individuals, n_selected, rng):
    return ["strangers"] * n_selected


def ending(*args):
    raise SystemExit(0)


def unchanged(space, first, second, rng):
    return first, second
"""


class Interruption:
    """Raises KeyboardInterrupt at one step of the record, counted from 0, where Python may."""

    def __init__(self, step: int) -> None:
        self.left = step

    def __call__(self, frame: FrameType, event: str, _: Any) -> Any:
        if frame.f_code.co_filename not in FILES:
            return None
        self.left -= event in ("call", "return") or frame.f_code.co_name == "write"
        if self.left < 0:
            sys.settrace(None)
            raise KeyboardInterrupt
        return self


def run(store: CampaignStore, interruption: Interruption | None = None) -> int:
    """Search until the end or an interrupt, and return how many were evaluated."""
    numbers = count()

    def evaluate(specifications: Sequence[Specification]) -> Iterator[Evaluated]:
        outcomes = map(stand_in_outcome, specifications)
        for specification, found in zip(specifications, outcomes, strict=True):
            next(numbers)
            yield FailedFlight("text: said") if specification[0].start % 3 == 0 else found

    mission, pool, clock = paper_mission(), pool_of(), map(float, CLOCK)
    sys.settrace(interruption)
    try:
        run_campaign(SETTINGS, mission, pool, evaluate, store, clock=clock.__next__, state_every=2)
    except KeyboardInterrupt:
        assert interruption is not None
    sys.settrace(None)
    return next(numbers)


@pytest.mark.parametrize("stride", [19, pytest.param(1, marks=slow)])
def test_what_was_evaluated_before_an_interrupt_is_stored_once_and_resumed(stride):
    with store_of([]) as whole:
        n_whole = run(whole)
        assert 0 < whole.n_failures < n_whole
        assert whole.kept("state", str)
        for step in count(0, stride):
            interruption = Interruption(step)
            with store_of([]) as store:
                n_evaluated = run(store, interruption)

                n_stored = store.n_evaluations + store.n_failures
                assert n_evaluated - 1 <= n_stored <= n_evaluated, step  # but the one at hand
                n_more = run(store)
                assert n_stored + n_more == n_whole, step
                assert store.digest() == whole.digest(), step
                assert [*store.generations()] == [*whole.generations()], step
                assert store.failures() == whole.failures(), step
                assert store.kept("state", str) == whole.kept("state", str), step
            if interruption.left >= 0:
                break
    assert step > 100


@pytest.fixture(autouse=True)
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A module own_functions in the current folder, forgotten again afterwards."""
    path = tmp_path / "own_functions.py"
    path.write_text(MODULE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    yield path
    sys.modules.pop("own_functions", None)


def campaign(**search: object) -> CampaignSettings:
    lines = [f"{key} = {value!r}" for key, value in search.items()]
    return CampaignSettings.parse("\n".join(["[search]", "generations = 2", *lines]), "case.toml")


def search_with(settings: CampaignSettings) -> CampaignStore:
    store = store_of(settings=settings)
    run_campaign(settings, paper_mission(), pool_of(), evaluate_stand_in, store)
    return store


def test_a_fitness_function_of_the_user_judges():
    store = search_with(campaign(fitness="own_functions:first_goal"))

    assert store.n_evaluations
    assert all(e.fitness == (float(e.outcome.believed[0]),) for e in store.evaluations())


def test_operators_of_the_user_vary():
    store = search_with(
        campaign(
            mutation_operator="own_functions:kept", crossover_operator="own_functions:unchanged"
        )
    )

    assert store.n_evaluations == 20


def test_a_selection_of_the_user_selects():
    store = search_with(
        campaign(selection="own_functions:worst_first", crossover=0.0, mutation=0.0)
    )

    first, *later = store.generations()
    assert {g.statistics["max"] for g in later} == {first.statistics["min"]}


def test_the_current_folder_does_not_stay_on_pythons_path():
    before = list(sys.path)

    chosen(campaign(fitness="own_functions:first_goal"), "fitness", {})

    assert sys.path == before


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("algorithm", "own_functions:absent"),
        ("selection", "own_functions:NUMBER"),
        ("fitness", "no_such_module:f"),
        ("mutation_operator", "own functions:f"),
        ("crossover_operator", "own_functions:"),
        ("fitness", ":f"),
    ],
)
def test_a_name_that_leads_nowhere_is_refused_by_file_and_key(key, name, refused):
    with refused(UsageError):
        require_settings(campaign(**{key: name}), paper_mission())


@pytest.mark.parametrize(
    "text",
    ["def broken(:\n", "\nimport no_such_thing\n", "x = 1\nx.y\n"],
)
def test_a_module_that_cannot_be_imported_is_refused_by_line(own, text, refused):
    own.write_text(text, encoding="utf-8")

    with refused(UsageError):
        require_settings(campaign(fitness="own_functions:f"), paper_mission())


@pytest.mark.parametrize(
    "key", ["algorithm", "selection", "fitness", "mutation_operator", "crossover_operator"]
)
def test_a_function_that_fails_is_refused_by_line(key, refused):
    with refused(UsageError):
        search_with(campaign(**{key: "own_functions:broken"}))


@pytest.mark.parametrize("function", ["nobody", "strangers", "ending"])
@pytest.mark.parametrize("algorithm", ["paper", "eaMuPlusLambda"])
def test_a_selection_that_selects_nobody_is_told_as_such(algorithm, function, refused):
    with refused(UsageError):
        search_with(campaign(algorithm=algorithm, selection=f"own_functions:{function}"))


def test_what_an_operator_must_not_make_is_refused(refused):
    with refused(SpecificationError):
        search_with(campaign(mutation_operator="own_functions:overlapping"))
