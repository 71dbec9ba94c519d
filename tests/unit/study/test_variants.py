import pytest

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.study.comparison import Sweep, Variant, compare, variants_of
from tests.support.comparisons import run_result

PAPERS = "crossover=0.7,population=20"


def test_values_are_listed_or_evenly_spaced_without_rounding():
    sweep = Sweep.parse("mutation=0.1:0.9:5,population=10,20,40:60:3")

    assert sweep.values == {
        "mutation": (0.1, 0.3, 0.5, 0.7, 0.9),
        "population": (10, 20, 40, 50, 60),
    }
    assert len(sweep.settings()) == 25


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (
            "crossover=0.3,0.7,population=20,20",
            ["crossover=0.3,population=20", "crossover=0.7,population=20"],
        ),
        ("crossover=0.3,population=10", ["crossover=0.3,population=10", PAPERS]),
    ],
)
def test_the_papers_setting_is_added_unless_it_is_one_of_them(text, names):
    sweep = Sweep.parse(text)

    variants = sweep.variants("eaSimple")

    assert [each.name for each in variants] == names
    assert sweep.papers == PAPERS
    assert {each.overrides["algorithm"] for each in variants} == {"eaSimple"}
    assert variants[-1].overrides == {"algorithm": "eaSimple", "crossover": 0.7, "population": 20}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "0.3",
        "crossover=",
        "crossover=high",
        "crossover=1/0",
        "crossover=0:1",
        "crossover=0:1:1",
        "crossover=0:1:2.5",
        "crossover=0:1:1000000000",
        "population=10,,20",
        "crosover=0.5",
        "seed=1,2",
        "crossover=0.5,crossover=0.6",
    ],
)
def test_what_is_no_sweep_is_refused(text, refused):
    with refused(UsageError):
        Sweep.parse(text)


def test_a_sweep_is_of_one_algorithm_and_a_variant_is_as_good_as_a_name(refused):
    sweep, own = Sweep.parse("crossover=0.3"), Variant("own", {"mutation_operator": "free"})

    assert variants_of(["paper", own]) == (Variant("paper", {"algorithm": "paper"}), own)
    assert variants_of(["paper"], sweep) == sweep.variants("paper")
    with refused(UsageError):
        variants_of(["paper", "random"], sweep)
    with refused(UsageError):
        variants_of([own, own])


def test_every_setting_is_tested_against_the_papers_and_told_better_worse_or_nothing():
    sweep = Sweep.parse("crossover=0.1,0.2,0.3")
    best = {"crossover=0.1": 20.0, "crossover=0.2": 40.0, "crossover=0.3": 60.0}
    runs = [
        run_result(
            name,
            seed,
            improvements=((1, best.get(name, 40.0) + seed),),
            hypervolume=None,
            at_once=(1,),
        )
        for name in sweep.settings()
        for seed in range(8)
    ]

    found = compare(tuple(sweep.settings()), runs, sweep)

    tests = [test for test in found.tests if test.measure == "fitness"]
    assert {test.second for test in tests} == {"crossover=0.7"}
    assert {test.first: test.verdict for test in tests} == {
        "crossover=0.1": "worse",
        "crossover=0.2": "not shown",
        "crossover=0.3": "better",
    }
    assert found.with_values({"crossover": 0.2}) == tuple(40.0 + seed for seed in range(8))
    assert len(found.with_values({})) == 24, "the paper's setting is none of the combinations"
