"""Which engine is chosen, what the record holds, and what has to repeat itself."""

import json
from dataclasses import replace
from itertools import cycle

import pytest

from mrsfi.engines import AS_RECORDED, again, chosen
from mrsfi.explaining import NamedSpecification, require_repeatable
from mrsfi_runtime.cosimulation.bus_topics import Patience
from mrsfi_runtime.errors import RecordError, ReplayMismatch, UsageError
from mrsfi_runtime.record.engine_settings import EngineSettings, Workers
from tests.support.campaigns import outcome

URL = "ws://127.0.0.1:9090"
WORLD = {"name": "rosbridge", "url": URL, "side": "ci"}
ON_BUS = EngineSettings(**WORLD, client="twisted")
NODE = EngineSettings("rosbridge", side="injector", node="node")
SUBJECT = NamedSpecification("best", "evaluation 3", (), ())


def recorded(settings):
    """Return settings as a record gives them back."""
    return EngineSettings.from_json(json.loads(json.dumps(settings.as_json())))


def test_options_become_settings_and_the_rest_is_usual():
    assert chosen({}) == EngineSettings("reference")
    assert chosen({**WORLD, "timeout": 45.0}).patience == Patience(45.0, handshake=45.0)
    assert chosen({"side": "injector", "url": URL}) == EngineSettings(
        **{**WORLD, "side": "injector"}, node_pace="answer", node_reset="service"
    )


def test_a_record_has_what_belongs_to_the_engine_and_what_is_unusual():
    settings = replace(NODE, url=f"{URL}/?token=0123456789abcdef", node_pace="20", is_bundled=True)
    settings = replace(settings, ros=2, timeout=3.0, world_prefix="/w")
    settings = replace(settings, node_left_out=("f1",), unrepeated="it has weather")

    assert json.dumps(replace(ON_BUS, name="compiled").as_json()) == '{"engine": "compiled"}'
    assert json.dumps(
        replace(settings, node_left_out=("f1",), unrepeated="it has weather").as_json()
    ) == (
        '{"engine": "rosbridge", "unrepeated": "it has weather", "bus": {"url": '
        '"ws://127.0.0.1:9090/", "client": "wire", "side": "injector", "bundle": true, "ros": 2, '
        '"world_prefix": "/w", "timeout": 3.0, "node": {"command": "node", "sha256": "", "pace": '
        '"20", "reset": "restart", "mapping": "", "prefix": "", "repeats": 1, "left_out": ["f1"]}}}'
    )


def test_a_record_gives_back_the_settings_it_was_made_of():
    others = ({"ros": 2}, {"timeout": 45.0}, {"is_bundled": True})
    buses = (ON_BUS, *(replace(ON_BUS, **other) for other in others))
    for settings in (EngineSettings(), EngineSettings("rosbridge"), *buses):
        assert chosen(AS_RECORDED, "auto", recorded(settings)) == settings


def test_options_beat_the_record():
    record = EngineSettings("rosbridge", url=URL)

    assert chosen({"name": "reference"}, recorded=record) == EngineSettings("reference")
    assert chosen({"url": "ws://127.0.0.1:1"}, recorded=record).url == "ws://127.0.0.1:1"


@pytest.mark.parametrize(
    ("record", "given", "found"),
    [
        (ON_BUS, {"name": "compiled"}, "mrsfi's own simulation and the generated code"),
        (ON_BUS, {**WORLD, "side": "both"}, "mrsfi's own simulation and the generated code"),
        (EngineSettings(), WORLD, "an external simulation"),
        (EngineSettings("rosbridge"), WORLD, "an external simulation"),
        (EngineSettings(), {"side": "injector"}, "an external node"),
        (NODE, {"url": URL}, "an external node and simulation"),
    ],
)
def test_a_campaign_is_flown_again_by_the_parts_that_flew_it(record, given, found):
    said = f"flown with {record.parts}; found {found}, which counts"

    with pytest.raises(UsageError, match=said):
        again(given, record)
    with pytest.raises(UsageError, match=said):
        chosen(given, recorded=record)


@pytest.mark.parametrize("name", ["auto", "compiled", "reference", "rosbridge"])
def test_what_ours_flew_any_engine_of_ours_flies_again(name):
    for record in (EngineSettings("compiled"), EngineSettings("rosbridge", URL)):
        assert again({"name": name}, record) == EngineSettings(name)


def test_what_does_not_repeat_itself_is_gone_on_with_and_not_flown_again():
    record = replace(ON_BUS, unrepeated="it has weather")

    assert chosen(AS_RECORDED, recorded=record) == record
    with pytest.raises(ReplayMismatch, match="cannot be flown again: it has weather; to fly one"):
        again(AS_RECORDED, record)


def test_a_node_flies_on_as_recorded_unless_it_is_another():
    record = replace(
        chosen({"side": "injector", "node": "node"}), node_repeats=3, node_left_out=("f1",)
    )

    assert chosen(AS_RECORDED, recorded=recorded(record)) == record
    with pytest.raises(RecordError, match="another node; its pace: found '20', recorded 'barrier'"):
        chosen({"node_pace": "20"}, recorded=record)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"url": URL}, "--url needs --engine rosbridge; the reference engine has no bus"),
        ({"name": "reference", "is_bundled": False}, "--bundle needs --engine rosbridge"),
        ({"name": "rosbridge", "side": "ci"}, "--side ci needs --url"),
        ({"name": "rosbridge", "world_prefix": "/w"}, "--world-prefix needs --url"),
        ({"name": "rosbridge", "node_pace": "20"}, "--node-pace needs --side injector"),
        ({"side": "injector"}, "--side injector needs --node 'COMMAND {url}'"),
        ({"side": "injector", "node": "node", "node_pace": "0"}, "--node-pace: found '0'"),
        ({"side": "injector", "url": URL, "node_pace": "barrier"}, "--node-pace barrier needs"),
        ({"side": "injector", "url": URL, "node_reset": "restart"}, "--node-reset restart needs"),
    ],
)
def test_options_that_make_no_sense_are_refused(given, expected):
    with pytest.raises(UsageError, match=expected):
        chosen(given)


def test_only_a_server_of_its_own_can_have_several_workers():
    Workers(8).require_sense(EngineSettings("rosbridge"))
    Workers(1).require_sense(EngineSettings("rosbridge", url=URL))
    with pytest.raises(UsageError, match="--workers 2"):
        Workers(2).require_sense(EngineSettings("rosbridge", url=URL))


class Simulation:
    """Finds one outcome after the other."""

    def __init__(self, *outcomes):
        self._outcomes = cycle(outcomes)

    def evaluate(self, specification):
        assert specification == SUBJECT.specification
        return next(self._outcomes)


def test_one_that_flies_differently_is_refused(refused):
    with refused(ReplayMismatch):
        require_repeatable(Simulation(outcome([7]), outcome([8])), SUBJECT)


def test_one_that_repeats_itself_is_not():
    require_repeatable(Simulation(outcome([7])), SUBJECT)
