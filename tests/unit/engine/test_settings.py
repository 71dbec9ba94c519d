"""Which engine is chosen, from the command line and from a record."""

from dataclasses import replace

import pytest

from mrsfi.engines import EngineOptions, recorded_engine
from mrsfi_runtime.cosimulation.waiting import Patience
from mrsfi_runtime.engine.node_settings import NodeSettings
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.errors import ReplayMismatch, UsageError
from mrsfi_runtime.record.manifest import EngineRecord

URL = "ws://127.0.0.1:9090"
WORLD = EngineOptions("rosbridge", URL, side="ci")
NODE = EngineSettings("rosbridge", node=NodeSettings("node"))
BUS = EngineSettings("rosbridge", url=URL, client="twisted", has_simulation=False)


def test_without_options_the_reference_flies():
    assert EngineOptions().settings() == EngineSettings("reference")


def test_options_become_settings():
    options = EngineOptions("rosbridge", URL, "2", "twisted", "ci", 3.0)

    settings = options.settings()

    assert settings == EngineSettings(
        "rosbridge", URL, 2, "twisted", has_simulation=False, patience=Patience(tick=3.0)
    )


def test_a_record_gives_back_the_settings_it_was_made_of():
    others = ({"ros": 2}, {"patience": Patience(45.0, 45.0)}, {"is_bundled": True})
    buses = (BUS, *(replace(BUS, **other) for other in others))
    for settings in (EngineSettings(), EngineSettings("rosbridge"), *buses):
        record = EngineRecord.from_json(recorded_engine(settings).as_json())

        assert EngineOptions().settings(record) == settings


def test_the_command_line_beats_the_record():
    record = recorded_engine(EngineSettings("rosbridge", url=URL))

    assert EngineOptions(engine="reference").settings(record) == EngineSettings("reference")
    assert EngineOptions(url="ws://127.0.0.1:1").settings(record).url == "ws://127.0.0.1:1"


@pytest.mark.parametrize(
    "options", [EngineOptions("reference"), EngineOptions("rosbridge", URL, side="both")]
)
def test_a_campaign_on_somebody_elses_simulation_stays_there(options):
    with pytest.raises(UsageError, match="flown with an external simulation; found mrsfi"):
        options.settings(recorded_engine(BUS))


@pytest.mark.parametrize(
    ("recorded", "options", "found"),
    [
        (BUS, EngineOptions("compiled"), "mrsfi's own simulation and the generated code"),
        (EngineSettings(), WORLD, "an external simulation"),
        (EngineSettings("rosbridge"), WORLD, "an external simulation"),
        (EngineSettings(), EngineOptions(side="injector"), "an external node"),
        (NODE, EngineOptions(url=URL), "an external node and simulation"),
    ],
)
def test_a_campaign_is_flown_again_by_the_parts_that_flew_it(recorded, options, found):
    record = recorded_engine(recorded)

    with pytest.raises(UsageError, match=f"flown with {record.parts}; found {found}, whose counts"):
        options.again(record)


@pytest.mark.parametrize("name", ["auto", "compiled", "reference", "rosbridge"])
def test_what_ours_flew_any_engine_of_ours_flies_again(name):
    for recorded in (EngineSettings("compiled"), EngineSettings("rosbridge", URL)):
        assert EngineOptions(name).again(recorded_engine(recorded)) == EngineSettings(name)


def test_what_does_not_repeat_itself_is_gone_on_with_and_not_flown_again():
    record = replace(recorded_engine(BUS), unrepeated="it has weather")

    assert EngineOptions().settings(record) == BUS
    with pytest.raises(ReplayMismatch, match="cannot be flown again: it has weather; to fly one"):
        EngineOptions().again(record)


def test_a_record_keeps_no_token():
    settings = EngineSettings("rosbridge", url=f"{URL}/?token=0123456789abcdef")

    assert "0123456789abcdef" not in str(recorded_engine(settings))


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (EngineOptions(url=URL), "--url needs --engine rosbridge"),
        (EngineOptions("reference", client="twisted"), "--client needs --engine rosbridge"),
        (EngineOptions("reference", timeout=3.0), "--timeout needs --engine rosbridge"),
        (EngineOptions("rosbridge", side="ci"), "--side ci needs --url"),
    ],
)
def test_options_that_make_no_sense_are_refused(options, expected):
    with pytest.raises(UsageError, match=expected):
        options.settings()


def test_only_a_server_of_its_own_can_have_several_workers():
    EngineSettings("rosbridge").require_workers(8)
    EngineSettings("rosbridge", url=URL).require_workers(1)
    with pytest.raises(UsageError, match="--workers 2"):
        EngineSettings("rosbridge", url=URL).require_workers(2)
