"""Which engine is chosen, what the record holds, and what has to repeat itself."""

import json
import os
from dataclasses import replace
from itertools import cycle

import pytest

from mrsfi.engines import AS_RECORDED, again, chosen
from mrsfi.explaining import NamedSpecification, require_repeatable
from mrsfi_runtime.cosimulation.bus_topics import Patience
from mrsfi_runtime.errors import RecordError, ReplayMismatch, UsageError
from mrsfi_runtime.record import engine_settings
from mrsfi_runtime.record.engine_settings import EngineSettings, Workers
from tests.support.campaigns import outcome

URL = "ws://127.0.0.1:9090"
WORLD = {"name": "rosbridge", "url": URL, "side": "ci"}
ON_BUS = EngineSettings(**WORLD, client="twisted")
NODE = EngineSettings("rosbridge", side="injector", node="node")
ON_ONE_SERVER = EngineSettings("rosbridge", URL, side="injector", node_pace="answer")
INSIDE = {"side": "injector", "url": URL, "world": "built-in"}
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
        '"world_prefix": "/w", "timeout": 3.0, "node": {"command": "node", "sha256": [], "pace": '
        '"20", "reset": "restart", "mapping": "", "prefix": "", "left_out": ["f1"]}}}'
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
        (ON_ONE_SERVER, {"world": "built-in"}, "an external node"),
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


def test_the_world_is_inside_although_the_node_is_at_a_server_and_goes_on_as_recorded():
    record = chosen(INSIDE)

    assert record.parts == "an external node"
    assert chosen(AS_RECORDED, recorded=recorded(record)) == record
    assert "world" not in ON_ONE_SERVER.as_json()["bus"]  # as in records from before the option
    assert ON_ONE_SERVER.parts == "an external node and simulation"


def test_what_does_not_repeat_itself_is_gone_on_with_and_not_flown_again():
    record = replace(ON_BUS, unrepeated="it has weather")

    assert chosen(AS_RECORDED, recorded=record) == record
    with pytest.raises(ReplayMismatch, match="cannot be flown again: it has weather; to fly one"):
        again(AS_RECORDED, record)


def test_a_world_flies_on_as_recorded_unless_it_is_another():
    record = replace(chosen({"world": "python w.py {url}", "late": "7%"}), repeats=3)

    assert (record.name, record.side, record.parts) == ("rosbridge", "ci", "an external simulation")
    assert record.most_late(1000) == 70
    assert chosen(AS_RECORDED, recorded=recorded(record)) == record
    with pytest.raises(RecordError, match="another simulation; its command: found 'v', recorded"):
        chosen({"world": "v"}, recorded=record)


def test_files_of_a_world_that_differ_from_the_record_are_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("robots.py", "it/world.py", "it/water.xml", "it/a.log", "it/__pycache__/a.py"):
        path = tmp_path / "worlds" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("", encoding="utf-8")
    (tmp_path / "search.py").write_text("", encoding="utf-8")
    record = chosen({"world": "python worlds/it/world.py {url}"})

    for name in ("it/a.log", "it/b.log", "it/__pycache__/a.py", "../search.py", "notes.md"):
        (tmp_path / "worlds" / name).write_text("1", encoding="utf-8")
    assert chosen(AS_RECORDED, recorded=recorded(record)) == record
    (tmp_path / "worlds" / "robots.py").write_text("1", encoding="utf-8")
    (tmp_path / "worlds" / "it" / "water.xml").unlink()
    (tmp_path / "worlds" / "it" / "more.py").write_text("", encoding="utf-8")
    with pytest.raises(
        RecordError,
        match=r"another simulation; its files have changed, or are new or gone: "
        r"worlds/it/more\.py, worlds/it/water\.xml, worlds/robots\.py; expected the same",
    ):
        chosen(AS_RECORDED, recorded=recorded(record))
    one_hash = replace(record, world_sha256="0" * 64)  # as mrsfi 0.3 recorded it of a node
    assert chosen(AS_RECORDED, recorded=recorded(one_hash)).world == record.world


def test_an_older_record_has_repeats_among_what_is_of_the_node():
    record = replace(NODE, repeats=3).as_json()
    del record["bus"]["repeats"]
    record["bus"]["node"]["repeats"] = 3

    assert EngineSettings.from_json(record).repeats == 3


def test_a_node_flies_on_as_recorded_unless_it_is_another():
    record = replace(chosen({"side": "injector", "node": "node"}), repeats=3, node_left_out=("f1",))

    assert chosen(AS_RECORDED, recorded=recorded(record)) == record
    with pytest.raises(RecordError, match="another node; its pace: found '20', recorded 'barrier'"):
        chosen({"node_pace": "20"}, recorded=record)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"url": URL}, "--url needs --engine rosbridge; the reference engine has no bus"),
        ({"name": "reference", "is_bundled": False}, "--bundle needs --engine rosbridge"),
        (
            {"name": "rosbridge", "side": "ci"},
            "--side ci needs --url, .*, or --world 'COMMAND {url}'",
        ),
        (
            {"name": "rosbridge", "side": "simulation"},
            "--side simulation needs --url, .* both sides use$",
        ),
        ({"world": "w", "side": "simulation"}, "--side simulation: found --world"),
        ({"world": "w", "url": URL}, f"--world: found --url {URL}, too; expected one of them"),
        ({"world": "w", "side": "both"}, "--side both: found --world, which replaces"),
        ({"world": "w", "name": "compiled"}, "--world needs --engine rosbridge"),
        ({"world": "w", "world_prefix": "/w"}, "--world-prefix needs --url"),
        ({"name": "rosbridge", "world_reset": "restart"}, "--world-reset needs --world COMMAND"),
        ({"world": "w", "late": "0.05"}, "--late: found '0.05'; expected a share such as 5%"),
        ({"world": "w", "late": "101%"}, "--late: found '101%'"),
        ({"name": "rosbridge", "world_prefix": "/w"}, "--world-prefix needs --url"),
        ({"name": "rosbridge", "node_pace": "20"}, "--node-pace needs --side injector"),
        ({"side": "injector"}, "--side injector needs --node 'COMMAND {url}'"),
        ({"side": "injector", "node": "node", "node_pace": "0"}, "--node-pace: found '0'"),
        ({"side": "injector", "url": URL, "node_pace": "barrier"}, "--node-pace barrier needs"),
        ({"side": "injector", "url": URL, "node_reset": "restart"}, "--node-reset restart needs"),
        ({**WORLD, "world": "built-in"}, "--world built-in: not possible with --side ci"),
        ({**INSIDE, "world_prefix": "/w"}, "--world-prefix needs --url, .*, and no --world built-"),
        ({"name": "ros2"}, "--side injector needs --node 'COMMAND {domain}', .* or --domain"),
        (
            {"name": "ros2", "side": "ci"},
            "--engine ros2: found --side ci; expected --side injector",
        ),
        ({"domain": 7, "url": URL}, "--engine ros2: found --url, which needs --engine rosbridge"),
        ({"domain": 7, "is_bundled": True}, "--engine ros2: found --bundle, which needs"),
        ({"domain": 233}, "--domain: found 233; expected a DDS domain, 0 to 232"),
        ({"domain": 7, "name": "rosbridge"}, "--domain 7: needs --engine ros2"),
    ],
)
def test_options_that_make_no_sense_are_refused(given, expected):
    with pytest.raises(UsageError, match=expected):
        chosen(given)


def test_a_node_of_ros_2_flies_on_as_recorded():
    record = chosen({"name": "ros2", "node": "ros2 run patrol patrol"})

    assert (record.side, record.node_pace, record.node_reset) == ("injector", "barrier", "restart")
    assert record.parts == "an external node"
    assert chosen(AS_RECORDED, recorded=recorded(record)) == record
    assert chosen({"domain": 7, "world_prefix": "/w"}).parts == "an external node and simulation"


def test_what_ros_2_needs_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setattr(engine_settings, "find_spec", lambda _: None)

    with pytest.raises(UsageError, match=r"install it with: pip install 'mrsfi\[ros2\]'"):
        chosen({"domain": 7})


def test_only_a_server_of_its_own_can_have_several_workers():
    Workers(8).require_sense(EngineSettings("rosbridge"))
    Workers(1).require_sense(EngineSettings("rosbridge", url=URL))
    with pytest.raises(UsageError, match="--workers 2: found --url, whose topics belong to one"):
        Workers(2).require_sense(EngineSettings("rosbridge", url=URL))
    with pytest.raises(UsageError, match="--workers 2: found --domain"):
        Workers(2).require_sense(EngineSettings("ros2", domain=7))


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


@pytest.mark.parametrize(
    ("engine", "number", "expected"),
    [
        (EngineSettings(), None, os.cpu_count()),
        (EngineSettings(), 3, 3),
        (EngineSettings("rosbridge", side="ci", url="ws://localhost:1"), None, 1),
        (EngineSettings("ros2", side="injector", domain=0), None, 1),
    ],
)
def test_one_flies_at_a_url_or_domain_else_one_for_each_processor(engine, number, expected):
    assert Workers(number).count(engine) == expected
