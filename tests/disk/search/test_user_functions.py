import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from mrsfi_runtime.errors import MrsfiError, SpecificationError, UsageError
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.fitness import chosen
from mrsfi_runtime.search.run import require_settings, run_campaign
from tests.support.campaigns import store_of
from tests.support.search import evaluate_stand_in, paper_mission, pool_of

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


@pytest.fixture
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


def run(settings: CampaignSettings) -> CampaignStore:
    store = store_of(settings=settings)
    run_campaign(settings, paper_mission(), pool_of(), evaluate_stand_in, store)
    return store


@pytest.mark.usefixtures("own")
def test_a_fitness_function_of_the_user_judges():
    store = run(campaign(fitness="own_functions:first_goal"))

    assert store.n_evaluations
    assert all(e.fitness == (float(e.outcome.believed[0]),) for e in store.evaluations())


@pytest.mark.usefixtures("own")
def test_operators_of_the_user_vary():
    store = run(
        campaign(
            mutation_operator="own_functions:kept", crossover_operator="own_functions:unchanged"
        )
    )

    assert store.n_evaluations == 20


@pytest.mark.usefixtures("own")
def test_a_selection_of_the_user_selects():
    store = run(campaign(selection="own_functions:worst_first", crossover=0.0, mutation=0.0))

    first, *later = store.generations()
    assert {g.statistics["max"] for g in later} == {first.statistics["min"]}


@pytest.mark.usefixtures("own")
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
@pytest.mark.usefixtures("own")
def test_a_name_that_leads_nowhere_is_refused_by_file_and_key(key, name, refused):
    with refused(UsageError):
        require_settings(campaign(**{key: name}), paper_mission())


@pytest.mark.parametrize(
    "text",
    ["def broken(:\n", "\nimport no_such_thing\n", "x = 1\nx.y\n"],
)
def test_a_module_that_cannot_be_imported_is_told_by_line(own, text, refused):
    own.write_text(text, encoding="utf-8")

    with refused(UsageError):
        require_settings(campaign(fitness="own_functions:f"), paper_mission())


@pytest.mark.parametrize(
    "key", ["algorithm", "selection", "fitness", "mutation_operator", "crossover_operator"]
)
@pytest.mark.usefixtures("own")
def test_a_function_that_fails_is_told_by_line(key, refused):
    with refused(UsageError):
        run(campaign(**{key: "own_functions:broken"}))


@pytest.mark.parametrize("function", ["nobody", "strangers", "ending"])
@pytest.mark.parametrize("algorithm", ["paper", "eaMuPlusLambda"])
@pytest.mark.usefixtures("own")
def test_a_selection_that_selects_nobody_is_told_as_such(algorithm, function, refused):
    with refused(UsageError):
        run(campaign(algorithm=algorithm, selection=f"own_functions:{function}"))


@pytest.mark.parametrize("value", ["None", "'much'", "[1]", "float('nan')"])
def test_a_fitness_that_is_no_number_is_told(own, value, refused):
    own.write_text(f"def fitness(findings):\n    return {value}\n", encoding="utf-8")

    with refused(MrsfiError):
        run(campaign(fitness="own_functions:fitness"))


@pytest.mark.usefixtures("own")
def test_what_an_operator_must_not_make_is_refused(refused):
    with refused(SpecificationError):
        run(campaign(mutation_operator="own_functions:overlapping"))
