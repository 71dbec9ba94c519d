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
    ("line", "message"),
    [
        ("poplation = 20", "case.toml: [search] found unknown key 'poplation'; expected one of al"),
        ("population = 0", "[search] population: found 0; expected a whole number >= 1"),
        ("population = true", "[search] population: found True; expected a whole number >= 1"),
        ("population = 20.0", "[search] population: found 20.0; expected a whole number >= 1"),
        ("generations = -1", "[search] generations: found -1; expected a whole number >= 0"),
        ("crossover = 1.5", "[search] crossover: found 1.5; expected a number 0 … 1"),
        ("mutation = nan", "[search] mutation: found nan; expected a number 0 … 1"),
        ("mutation = true", "[search] mutation: found True; expected a number 0 … 1"),
        ('mutation_share = "x"', "[search] mutation_share: found 'x'; expected a number 0 … 1"),
        ("algorithm = 3", "[search] algorithm: found 3; expected a name"),
        ('goals = "g1"', "[search] goals: found 'g1'; expected a list of different goal IDs"),
        ('goals = ["g1", "g1"]', "expected a list of different goal IDs"),
        ("goals = [1]", "expected a list of different goal IDs"),
        ("seed = -1", "[search] seed: found -1; expected a whole number 0 … 9223372036854775807"),
        ("evaluations = 0", "[search] evaluations: found 0; expected a whole number >= 1"),
        ("max_failures = 0", "[search] max_failures: found 0; expected a whole number >= 1"),
        ("seed = 1\nseed = 2", "case.toml: is not TOML: "),
        ("[engine]", "case.toml: found 'engine'; expected one table, [search]"),
        (
            "violations = 'phantom'",
            "violations: found 'phantom'; expected one of believed, true, masked, missed",
        ),
        ("violations = ['true']", "violations: found ['true']; expected one of believed,"),
        ("minimise = 'ticks'", "minimise: found 'ticks'; expected one of faults, fault_ticks"),
        ("replications = 0", "replications: found 0; expected a whole number 1 … 1000"),
        ("offspring = 0", "offspring: found 0; expected a whole number >= 1"),
        ("mutation_operator = ''", "mutation_operator: found ''; expected a name"),
    ],
)
def test_wrong_settings_name_file_key_found_and_expected(line, message):
    with pytest.raises(UsageError) as caught:
        CampaignSettings.parse(f"[search]\n{line}\n", "case.toml")

    assert message in str(caught.value)


@pytest.mark.parametrize("text", ["", "search = 3"])
def test_a_file_without_its_table_is_refused(text):
    with pytest.raises(UsageError, match=r"has no table \[search\]"):
        CampaignSettings.parse(text, "case.toml")


def test_a_wrong_override_is_refused():
    with pytest.raises(UsageError, match="option seed: found 'x'"):
        CampaignSettings.parse(CASE, "case.toml", seed="x")


def test_a_missing_or_unreadable_file_is_refused(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"[search]\n# \xe9\n")

    for name in ("none.toml", "latin.toml"):
        with pytest.raises(UsageError, match="cannot be read"):
            CampaignSettings.load(tmp_path / name)


def test_replications_fly_on_the_mission_seeds_that_follow():
    settings = CampaignSettings(mission_seed=2**63 - 2, replications=3)

    assert settings.mission_seeds == (2**63 - 2, 2**63 - 1, 0)


def test_a_number_of_things_is_at_least_one_and_a_mission_seed_at_least_zero():
    assert (require_whole("workers", 1), require_seed(0)) == (1, 0)
    with pytest.raises(UsageError, match="workers: found 0; expected"):
        require_whole("workers", 0)
    with pytest.raises(UsageError, match="seed: found -1; expected"):
        require_seed(-1)
