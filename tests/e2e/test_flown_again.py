"""Who may fly a campaign again: one answer for all of the API and the command line."""

from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from shutil import copytree, rmtree

import pytest

from mrsfi.campaign import Campaign
from mrsfi.mission import load
from mrsfi_runtime.cli.main import main
from mrsfi_runtime.errors import MrsfiError, RecordError
from mrsfi_runtime.record.database import canonical
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import mrsfi
from tests.support.planted_world import OTHER, SAME, external_world
from tests.support.rendezvous import NAME
from tests.support.report_page import data_of, unpacked
from tests.tiers import night, slow

RUN = "runs/it"
NOWHERE = "ws://127.0.0.1:1"
OF_WORLD = EngineSettings("rosbridge", NOWHERE, side="ci", is_bundled=True)
OF_NODE = EngineSettings("rosbridge", side="injector", node="python node.py {url}")
BEST = 2
"""The most critical evaluation of the campaign."""

CALLS = {
    "fly": lambda run: run.fly(BEST),
    "explain": lambda run: run.explain(),
    "keep": lambda run: run.keep(n_seeds=2),
    "show": lambda run: run.show(1),
}
COMMANDS = {
    "replay": ("replay", RUN),
    "explain": ("explain", RUN),
    "explain --all": ("explain", RUN, "--all"),
    "weaknesses --seeds 1": ("weaknesses", RUN, "--seeds", "1"),
    "weaknesses --seeds 2": ("weaknesses", RUN, "--seeds", "2"),
    "weaknesses --map": ("weaknesses", RUN, "--map", "1", "map.csv"),
    "weaknesses --fmea": ("weaknesses", RUN, "--fmea", "fmea.csv"),
    "monitors": ("monitors", RUN),
    "keep --seeds 2": ("keep", RUN, "--weakness", "1", "--seeds", "2"),
    "show": ("show", RUN, "1"),
    "check ARCHIVE": ("check", "it.zip"),
}
OPERATIONS = [*(f"Campaign.{name}" for name in CALLS), *COMMANDS]
GOES_ON = {"evolve --resume": ("evolve", "--resume", RUN)}
"""What flies on, also where nothing repeats itself."""


@pytest.fixture
def place(found, tmp_path):
    """A copy of the small mission, with a campaign of our own that looked for weaknesses."""
    return Path(copytree(found, tmp_path / "place"))


def recorded_as(place, engine):
    """Have the record of the campaign name an engine, as if that had flown what it holds."""
    with CampaignStore.open(place / RUN) as store:
        store.keep("manifest", canonical(replace(store.manifest, engine=engine).as_json()))


def ended(place, operation, *options):
    """Return the exit code and the last sentence of a call of the API, or of a command."""
    errors = StringIO()
    with chdir(place), redirect_stdout(StringIO()), redirect_stderr(errors):
        words = (COMMANDS | GOES_ON).get(operation)
        if words is not None:
            if "it.zip" in words:
                assert main(["pack", RUN, "--out", "it.zip"]) == 0
            code = main([*words, *options])
            return code, errors.getvalue().rstrip().rpartition("\n")[2]
        try:
            CALLS[operation.removeprefix("Campaign.")](Campaign(RUN))
        except MrsfiError as error:
            return error.exit_code, str(error)
    return 0, ""


def all_ended(place, *left_out):
    """Return the same of every operation; what one keeps is gone before the next.

    ``check ARCHIVE`` asks no external parts, see ``test_archives.py``.
    """
    told = {}
    for operation in [each for each in OPERATIONS if each not in {"check ARCHIVE", *left_out}]:
        told[operation] = ended(place, operation)
        rmtree(place / "models" / NAME / "regressions", ignore_errors=True)
    return told


def require_same(told, code, sentence):
    """Require that all ended with an exit code, and say alike why."""
    others = {
        name: each for name, each in told.items() if each[0] != code or sentence not in each[1]
    }
    assert others == {}


def report_of(place):
    """Write the report of the campaign, and return why its page has no flights."""
    with chdir(place):
        Campaign(RUN).report()
    shown = data_of(place / RUN / "report.html")["shown"].values()
    (reason,) = {unpacked(each)["no_flight"] for each in shown}
    return reason


@contextmanager
def world(place, url, kind):
    """Have the campaign be one of a world at a server, where a kind of it flies now."""
    recorded_as(place, replace(OF_WORLD, url=url))
    with external_world(url, place, kind):
        yield


@slow
def test_the_external_simulation_that_flew_it_flies_it_again(place, url):
    with world(place, url, SAME):
        require_same(all_ended(place, "weaknesses --map", "monitors"), 0, "")  # which take long
        page = report_of(place)
        with chdir(place):
            flight = Campaign(RUN).fly(BEST)

    with CampaignStore.open(place / RUN) as store:
        assert flight.outcome == store.evaluation(BEST).outcome
    assert "cannot be reached" not in page


@night
def test_another_external_simulation_is_refused_by_all(place, url):
    with world(place, url, OTHER):
        told = all_ended(place)
        told["evolve --resume"] = ended(place, "evolve --resume")
        said = report_of(place)

    require_same(told, 7, " differs from its record: digest ")
    assert " differs from its record: digest " in said


def test_an_external_simulation_that_is_not_there_is_told_of_by_all(place):
    recorded_as(place, OF_WORLD)

    require_same(all_ended(place), 8, f"{NOWHERE}: cannot be reached: ")
    assert f"{NOWHERE}: cannot be reached: " in report_of(place)


def test_what_does_not_repeat_itself_flies_nothing_again(place):
    recorded_as(place, replace(OF_WORLD, unrepeated="the world has weather"))
    said = "this campaign cannot be flown again: the world has weather; to fly one of its spec"

    require_same(all_ended(place), 7, said)
    assert said in report_of(place)


def test_another_node_than_the_one_that_flew_it_is_refused_by_all(place):
    recorded_as(place, OF_NODE)
    (place / "node.py").write_text("", encoding="utf-8")
    said = "flown with another node; its files have changed, or are new or gone: node.py; expected"

    require_same(all_ended(place), 9, said)
    assert said in report_of(place)


def test_a_comparison_is_not_gone_on_with_by_other_parts(place, monkeypatch, refused):
    monkeypatch.chdir(place)
    Path("case.toml").write_text("[search]\n", encoding="utf-8")
    load(NAME).compare(["random"], 1, 2, case="case.toml")
    world = EngineSettings("rosbridge", NOWHERE, side="ci")

    with refused(RecordError):
        load(NAME).compare(["random"], 2, 2, case="case.toml", engine=world)


def test_what_is_kept_of_a_node_is_checked_with_a_node(place):
    recorded_as(place, OF_NODE)
    mrsfi("keep", RUN, "--weakness", "1", "--name", "one", cwd=place)

    for words in (("check", NAME), ("keep", NAME, "--update")):
        refused = mrsfi(*words, "--engine", "reference", cwd=place, expected=2)
        assert (
            "one.toml: its limits are counts of an external node; expected the same, with --side "
            "injector"
        ) in refused.stderr + refused.stdout


def test_what_ours_flew_no_external_simulation_flies_again(place):
    options = ("--engine", "rosbridge", "--side", "ci", "--url", NOWHERE)
    told = {name: ended(place, name, *options) for name in COMMANDS if name != "show"}

    require_same(
        told,
        2,
        "this campaign was flown with mrsfi's own simulation and the generated code; found an "
        "external simulation, which counts differently; expected no --side; to fly its weaknesses "
        "in another world: mrsfi confirm",
    )
