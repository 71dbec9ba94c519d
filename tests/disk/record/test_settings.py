import json

import pytest

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.settings import CampaignSettings, require_seed, require_whole

CASE = """
[search]
algorithm = "paper"
population = 20
generations = 50
faults = 20
crossover = 0.7
mutation = 1
selection = "roulette"
fitness = "focused"
goals = ["g1", "g3"]
seed = 3
mission_seed = 4
"""


def test_a_campaign_file_is_read(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE, encoding="utf-8")

    settings = CampaignSettings.load(path)

    assert settings == CampaignSettings(
        mutation=1.0, fitness="focused", goals=("g1", "g3"), seed=3, mission_seed=4
    )
    assert type(settings.mutation) is float
    assert settings.source == str(path)


def test_what_a_file_leaves_out_has_the_papers_value():
    settings = CampaignSettings.parse("[search]", "case.toml")

    assert (settings.population, settings.generations, settings.faults) == (20, 50, 20)
    assert (settings.crossover, settings.mutation, settings.selection) == (0.7, 0.7, "roulette")


def test_overrides_replace_the_files_values_unless_none():
    settings = CampaignSettings.parse(CASE, "case.toml", seed=9, evaluations=100, algorithm=None)

    assert (settings.seed, settings.evaluations, settings.algorithm) == (9, 100, "paper")


def test_generations_given_beside_a_file_replace_its_evaluations():
    text = CASE + "evaluations = 300\n"

    assert CampaignSettings.parse(text, "case.toml").evaluations == 300
    settings = CampaignSettings.parse(text, "case.toml", generations=5)
    assert (settings.generations, settings.evaluations) == (5, None)
    settings = CampaignSettings.parse(text, "case.toml", generations=5, evaluations=200)
    assert settings.evaluations == 200


def test_settings_survive_json():
    settings = CampaignSettings.parse(CASE, "case.toml", evaluations=7)

    text = json.dumps(settings.as_json())

    assert "case.toml" not in text
    assert CampaignSettings.from_json(json.loads(text)) == settings
    assert CampaignSettings.from_json(CampaignSettings().as_json()) == CampaignSettings()


@pytest.mark.parametrize(
    "line",
    [
        "poplation = 20",
        "population = 0",
        "population = true",
        "population = 20.0",
        "generations = -1",
        "crossover = 1.5",
        "mutation = nan",
        "mutation = true",
        'mutation_share = "x"',
        "algorithm = 3",
        'goals = "g1"',
        'goals = ["g1", "g1"]',
        "goals = [1]",
        "seed = -1",
        "evaluations = 0",
        "max_failures = 0",
        "seed = 1\nseed = 2",
        "[engine]",
        "violations = 'phantom'",
        "violations = ['true']",
        "minimise = 'ticks'",
        "replications = 0",
        "offspring = 0",
        "mutation_operator = ''",
    ],
)
def test_wrong_settings_name_file_key_found_and_expected(line, refused):
    with refused(UsageError):
        CampaignSettings.parse(f"[search]\n{line}\n", "case.toml")


@pytest.mark.parametrize("text", ["", "search = 3"])
def test_a_file_without_its_table_is_refused(text, refused):
    with refused(UsageError):
        CampaignSettings.parse(text, "case.toml")


def test_a_wrong_override_is_refused(refused):
    with refused(UsageError):
        CampaignSettings.parse(CASE, "case.toml", seed="x")


def test_a_missing_or_unreadable_file_is_refused(tmp_path, refused):
    (tmp_path / "latin.toml").write_bytes(b"[search]\n# \xe9\n")

    for name in ("none.toml", "latin.toml"):
        with refused(UsageError):
            CampaignSettings.load(tmp_path / name)


def test_replications_fly_on_the_mission_seeds_that_follow():
    settings = CampaignSettings(mission_seed=2**63 - 2, replications=3)

    assert settings.mission_seeds == (2**63 - 2, 2**63 - 1, 0)


def test_a_number_of_things_is_at_least_one_and_a_mission_seed_at_least_zero(refused):
    assert (require_whole("workers", 1), require_seed(0)) == (1, 0)
    with refused(UsageError):
        require_whole("workers", 0)
    with refused(UsageError):
        require_seed(-1)
