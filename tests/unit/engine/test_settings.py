"""Which engine is chosen, from the command line and from a record."""

from dataclasses import replace

import pytest

from mrsfi.engines import EngineOptions, recorded_engine
from mrsfi_runtime.cosimulation.waiting import Patience
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.errors import UsageError

URL = "ws://127.0.0.1:9090"
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
    for settings in (EngineSettings(), EngineSettings("rosbridge"), BUS, replace(BUS, ros=2)):
        assert EngineOptions().settings(recorded_engine(settings)) == settings


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
