"""The reference engine flies as the independent simulation does, field by field and tick by tick.

``simulation.py`` was written from the pages alone. Where the two part, one of them does not do
what the pages say, or the pages do not say enough.
"""

import ast
import inspect
import io
import re
import shutil
import sys
import tokenize
from pathlib import Path
from random import Random

import pytest

from m2t.generate import generate
from m2t.models.load import write_specification
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.independent import digest, polygon, simulation
from tests.independent.crowd import draw_crowd
from tests.independent.limits import limits
from tests.independent.simulation import read_specification
from tests.independent.twins import Twins
from tests.support.edited import COLLECTIVE, write_body
from tests.support.models.builder import write
from tests.support.models.copies import edit
from tests.support.models.shapes import draw_specification, shape, write_drawn
from tests.support.own_metamodels import add_fault_type, add_faults, meaning, parameter
from tests.support.tree import ROOT
from tests.support.triggers import drawn_triggers, in_xmi, waiting
from tests.support.world import specification
from tests.tiers import seeds, slow

HARBOUR = Path(__file__).parent / "harbour"
"""A mission with all tasks and odd robots, and a pool of all types with odd targets."""
SHORT = ("tight_margins", "harbour")
LONG = ("uuv_sampling", "tight_energy")
PUBLISHED = ("depot", "undersea", "atlas_search", "atlas_crossing", "fleet_30")
MISSIONS = (*SHORT, *LONG)
N_SPECIFICATIONS = 25
SEEDS = (0, 1, 7, 2**32, 2**64 + 3, 123_456_789_012)
"""Mission seeds, of as many 32 bits as they take."""
SHAPES = {
    "one robot": (shape(1, 1, seed=14), 60),
    "three robots": (shape(3, 2, ("Visit", "GatherSamples"), seed=5), 60),
    "eleven robots": (shape(11, 4, ("AvoidCollision", "Patrol", "Track"), seed=1), 40),
    "thirty robots": (shape(30, 40, ("Stay",), seed=15), 20),
}
"""All nine tasks, maximum speeds and three messages a goal: shape, and the longest mission."""


@pytest.fixture(scope="module")
def harbour(tmp_path_factory):
    target = tmp_path_factory.mktemp("harbour")
    generate(HARBOUR, target)
    return Twins(HARBOUR, target)


@pytest.fixture
def twins(request):
    if request.param == "harbour":
        return request.getfixturevalue("harbour")
    return Twins(ROOT / "models" / request.param, ROOT / "generated" / request.param)


@pytest.mark.parametrize("seed", seeds(range(N_SPECIFICATIONS), 0, 8))
@pytest.mark.parametrize("twins", MISSIONS, indirect=True)
def test_random_specifications_fly_alike(twins, seed):
    twins.fly(specification(twins.code, seed), SEEDS[seed % len(SEEDS)])


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("twins", seeds(PUBLISHED, 0, 3), indirect=True)
def test_random_specifications_of_published_missions_fly_alike(twins, seed):
    twins.fly(specification(twins.code, seed), SEEDS[seed])


@pytest.mark.parametrize("twins", [*MISSIONS, *seeds(PUBLISHED, 0, 3)], indirect=True)
def test_missions_without_faults_fly_alike(twins):
    twins.fly((), 1)


@pytest.mark.parametrize("twins", seeds(MISSIONS, 0, 2), indirect=True)
def test_each_fault_alone_flies_alike(twins):
    n_ticks = twins.code.mission.duration
    for fault in twins.code.pool:
        twins.fly((TimedFault(fault.id, n_ticks // 6, n_ticks // 2, fault.values),), 1)


def with_triggers(name, folder, seed):
    """Return a mission twice whose pool declares triggers."""
    source = HARBOUR if name == "harbour" else ROOT / "models" / name
    models = shutil.copytree(source, folder / name)
    if name != "harbour":
        shutil.copytree(ROOT / "generated" / name, folder / "generated")
    else:
        generate(models, folder / "generated")
    code = load_code(folder / "generated")
    declared = in_xmi(drawn_triggers(Random(seed), code.mission, code.pool))
    edit(
        models / "faults.xmi",
        "</faults:FaultSpecification>",
        f"{declared}</faults:FaultSpecification>",
    )
    generate(models, folder / "generated")
    return Twins(models, folder / "generated")


@pytest.mark.parametrize("seed", seeds(range(6), 0, 2))
@pytest.mark.parametrize("name", MISSIONS)
def test_faults_that_wait_for_triggers_fly_alike(tmp_path, name, seed):
    """Some wait, and of what is waited for something happens in every mission."""
    twins, rng = with_triggers(name, tmp_path, seed), Random(seed)
    n_set_off = 0

    for n in range(2):
        faults = waiting(rng, specification(twins.code, 10 * seed + n), twins.code.pool)
        outcome = twins.fly(faults, SEEDS[n])
        told = zip(faults, outcome.applied, strict=True)
        n_set_off += sum(timed.trigger != "" and applied > 0 for timed, applied in told)

    assert n_set_off > 0


@pytest.mark.parametrize("n_ticks", [0.0, 1.0, 3.0, 1e6])
def test_ticks_of_delays_and_blocks_count_alike(harbour, n_ticks):
    harbour.fly((TimedFault("h1", 0, 60, (n_ticks,)), TimedFault("h2", 20, 90, (n_ticks,))), 3)


def test_what_was_falsified_is_kept_by_the_block_that_follows(harbour):
    false = TimedFault("h35", 20, 29, (30.0, 40.0, 0.0))
    blocked = TimedFault("h33", 30, 60, (12.0,))
    late = TimedFault("h1", 61, 90, (5.0,))

    harbour.fly((false, blocked, late), 4)


def unmixed(v):
    """Undo ``mixed``: every step of it can be undone."""
    v ^= v >> 16
    v = v * pow(0x846CA68B, -1, 2**32) % 2**32
    v ^= v >> 15 ^ v >> 30
    v = v * pow(0x7FEB352D, -1, 2**32) % 2**32
    return v ^ v >> 16


@pytest.mark.parametrize("tick", [0, 5])
def test_a_draw_that_is_a_bound_is_not_below_it(harbour, tick):
    """The seed follows from the draw that is wanted, which chance would bring about never."""
    sensor = next(each for each in harbour.mission.sensors if each.id == "ferry_stern")
    for bound in sensor.bounds:
        key = tick ^ unmixed(unmixed(bound) ^ (256 * sensor.index + simulation.SAMPLES))
        seed = unmixed(key ^ 0x9E3779B9)
        assert simulation.Weather(seed).draw(tick, sensor.index, simulation.SAMPLES) == bound

        harbour.fly((), seed)


def test_specifications_in_xmi_are_read_and_fly_alike(harbour, tmp_path):
    faults = (TimedFault("h23", 10, 40, (1.5, -3.0, 0.25)), TimedFault("h15", 5, 99, (12.0,)))
    path = tmp_path / "found.xmi"
    write_specification(HARBOUR, harbour.code.pool, faults, path, identifier="found")

    harbour.fly(faults, 5, read_specification(harbour.mission, path))


def test_the_simulation_and_its_digest_import_nothing_of_the_product_and_are_short():
    texts = [inspect.getsource(each) for each in (simulation, digest, polygon)]
    nodes = [node for text in texts for node in ast.walk(ast.parse(text))]
    names = {each.name for node in nodes if isinstance(node, ast.Import) for each in node.names}
    names |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}

    strange = {name for name in names if name.split(".")[0] not in sys.stdlib_module_names}
    ours = {f"tests.independent.{name}" for name in ("simulation", "polygon")}
    assert strange == {"lxml", *ours}
    assert len("".join(texts).splitlines()) < 1_250


def test_the_simulation_quotes_the_pages_as_they_are():
    """Who changes a sentence of the pages sees here what followed it."""
    pages = {"S": (ROOT / "docs/semantics.md"), "F": (ROOT / "docs/faults.md")}
    texts = {name: path.read_text("utf-8") for name, path in pages.items()}
    said = " ".join(re.sub("[*`]", "", "\n".join(texts.values())).split())
    source = "".join(map(inspect.getsource, (simulation, digest, polygon)))
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    comments = " ".join(
        token.string[1:] if token.type == tokenize.COMMENT else token.string[3:-3]
        for token in tokens
        if token.type == tokenize.COMMENT or token.string.startswith('"""')
    )
    comments = " ".join(comments.replace("`", "").split())
    quoted = {quote.rstrip(".,") for quote in re.findall(r'"([^"]+)"', comments)}
    sections = set(re.findall(r'\[([SF]) ([^],"]+)', comments))

    assert len(quoted) > 20
    assert [quote for quote in sorted(quoted) if quote not in said] == []
    assert [each for each in sorted(sections) if f"## {each[1]}" not in texts[each[0]]] == []


@pytest.mark.parametrize("seed", seeds(range(5), 0, 2))
@pytest.mark.parametrize("name", SHAPES)
def test_drawn_missions_fly_alike(tmp_path, name, seed):
    """Each under some drawn specifications, and each fault of its pool alone."""
    of, longest = SHAPES[name]
    rng = Random(f"{name} {seed}")
    models = write_drawn(tmp_path / "models", rng, of, longest)
    generate(models, tmp_path / "generated")
    twins = Twins(models, tmp_path / "generated")

    for _ in range(10):
        twins.fly(draw_specification(rng, twins.code), rng.getrandbits(40), may_round=True)
    for fault in twins.code.pool:
        whole = TimedFault(fault.id, 0, twins.code.mission.duration - 1, fault.values)
        twins.fly((whole,), rng.getrandbits(40), may_round=True)

    assert twins.n_digests > 0.9 * (10 + len(twins.code.pool))


@pytest.mark.parametrize("seed", seeds(range(200), 0, 2))
def test_drawn_missions_fly_alike_on_every_engine(tmp_path, seed):
    """Each under twenty drawn specifications: by the pages, interpreted, compiled, over a bus."""
    of, longest = [*SHAPES.values()][seed % len(SHAPES)]
    rng = Random(seed)
    models = write_drawn(tmp_path / "models", rng, of, longest)
    generate(models, tmp_path / "generated")
    twins = Twins(models, tmp_path / "generated")
    some = [draw_specification(rng, twins.code) for _ in range(20)]

    expected = [twins.fly(each, seed, may_round=True) for each in some]

    for name in ("compiled", "rosbridge"):
        with open_engine(EngineSettings(name), twins.code, seed) as engine:
            assert list(engine.evaluate_many(some)) == expected, name


@pytest.mark.parametrize("n_robots", seeds([12, 25, 30, 24, 45, 70], 0, 2))
@pytest.mark.parametrize("room", [15.0, 60.0, 300.0])
def test_crowds_fly_alike(tmp_path, n_robots, room):
    rng = Random(n_robots)
    models = write(tmp_path / "models", *draw_crowd(rng, n_robots, room))
    generate(models, tmp_path / "generated")
    twins = Twins(models, tmp_path / "generated")

    for seed in range(3):
        twins.fly(specification(twins.code, seed, 8), seed, may_round=True)

    assert twins.n_digests > 0


@pytest.mark.parametrize("off", [-1e-3, -2e-9, -5e-10, -1e-12, 0.0, 1e-12, 5e-10, 2e-9, 1e-3])
def test_what_stands_at_a_limit_is_judged_alike(tmp_path, off):
    models = write(tmp_path / "models", *limits(off))
    generate(models, tmp_path / "generated")
    twins = Twins(models, tmp_path / "generated")
    moved = [TimedFault(fault.id, 2, 8, fault.values) for fault in twins.code.pool]

    for seed in range(3):
        twins.fly((), seed)
        twins.fly(tuple(moved), seed)


def test_what_goals_remember_is_part_of_the_digest(tmp_path):
    """A reaction notes something in belief; truth remembers nothing."""
    generate(HARBOUR, tmp_path)
    body = "    goal_tasks.visit.react(ci, MOORING)\n    ci.goals[MOORING].memory[2] += 0.5\n"
    write_body(tmp_path / COLLECTIVE, "mooring.react", body)

    def react(goal, ci):
        simulation.react(goal, ci)
        ci.notes[goal.index].memory[2] += 0.5

    Twins(HARBOUR, tmp_path, {"mooring": react}).fly((), 1)


@slow
def test_types_of_a_teams_own_fly_alike(own_metamodels, tmp_path, monkeypatch):
    """False counts, which no type of ours makes, and another property of a robot."""
    faults = own_metamodels.folder / "faults.ecore"
    modes = {
        "ZERO": (), "FIXED": (7.9,), "INCREMENT": (2.5,), "DECREMENT": (3.5,),
        "INCREMENT_PERCENT": (33.0,), "DECREMENT_PERCENT": (12.5,), "RANDOM": (2.5, 40.5),
    }  # fmt: skip
    models = Path(shutil.copytree(HARBOUR, tmp_path / "models"))
    for mode, values in modes.items():
        for parent, struck in (("Sensor", "ferry_stern"), ("Message", "soundings_ferry")):
            name = f"{mode.title().replace('_', '')}{parent}Count"
            tag, kind = name[0].lower() + name[1:], "PERCENT" if "PERCENT" in mode else "COUNT"
            roles = ("LOWEST", "HIGHEST") if mode == "RANDOM" else ("",) * len(values)
            said = [
                parameter(f"BY{n}", range=kind, **({"role": role} if role else {}))
                for n, role in enumerate(roles)
            ]
            content = meaning(mode=mode, property="COUNT") + "".join(said)
            add_fault_type(faults, name, f"{parent}Fault", content)
            given = "".join(f' BY{n}="{value}"' for n, value in enumerate(values))
            element = f'<{tag}{given}><affected{parent} href="mission.xmi#{struck}"/></{tag}>'
            add_faults(models / "faults.xmi", {name: element})
    generate(models, tmp_path / "generated")
    monkeypatch.setattr(simulation, "TYPES", dict(simulation.fault_types(faults)))
    twins = Twins(models, tmp_path / "generated")

    own = [fault for fault in twins.code.pool if fault.id.endswith("Count")]
    assert len(own) == 2 * len(modes)
    for fault in own:
        twins.fly((TimedFault(fault.id, 20, 90, fault.values),), 1)


STUCK = """    robot = ci.robots[fault.target]
    if fault.age == 0:
        fault.memory[0] = inbox.robots[fault.target].speed + fault.memory[1]
    fault.memory[1] += 1.0
    robot.speed = fault.memory[0] + fault.values[0]
    robot.energy = robot.energy + fault.memory[1] * fault.values[1]
"""
DRIFT = """    obstacle = ci.obstacles[fault.target]
    obstacle.x += fault.values[0] * (fault.age + fault.memory[0])
    fault.memory[0] += 1.0
"""
LOSS = """    sensor = ci.sensors[fault.target]
    sensor.count = max(sensor.count - fault.age, 0)
    sensor.rate = sensor.rate + 1.0
"""


def stuck(ci, inbox, fault, k):
    memory = fault.memory[k]
    if ci.tick == fault.start:
        memory[0] = inbox["SPEED"][k] + memory[1]
    memory[1] += 1.0
    ci.speed[k] = memory[0] + fault.values[0]
    ci.energy[k] += memory[1] * fault.values[1]


def drift(ci, inbox, fault, k):
    x, y, z = ci.obstacle[k]
    ci.obstacle[k] = x + fault.values[0] * (ci.tick - fault.start + fault.memory[k][0]), y, z
    fault.memory[k][0] += 1.0


def loss(ci, inbox, fault, k):
    ci.count[k] = max(ci.count[k] - (ci.tick - fault.start), 0)
    ci.rate[k] += 1.0


@slow
def test_effects_of_a_teams_own_fly_alike(own_metamodels, tmp_path, monkeypatch):
    faults = own_metamodels.folder / "faults.ecore"
    models = Path(shutil.copytree(HARBOUR, tmp_path / "models"))
    types = {
        "Stuck": ("MessageFault", "SPEED ENERGY", "SPEED", "ENERGY"),
        "Drift": ("ObstacleFault", "OBSTACLE", "SHARE"),
        "Loss": ("MessageFault", "COUNT RATE"),
    }
    for name, (parent, properties, *ranges) in types.items():
        said = "".join(parameter(f"BY{n}", range=each) for n, each in enumerate(ranges))
        content = meaning(mode="OWN", property=properties) + said
        add_fault_type(faults, name, parent, content)
    element = "<{0} {1}><affected{2} href='mission.xmi#{3}'/></{0}>".format
    elements = {
        "stuck": element("stuck", 'BY0="1.5" BY1="2.0"', "Message", "fuel_ferry"),
        "silent": element("stuck", 'BY0="1.5" BY1="2.0"', "Message", "soundings_ferry"),
        "drift": element("drift", 'BY0="0.5"', "Obstacle", "buoy"),
        "loss": element("loss", "", "Message", "soundings_ferry"),
    }
    add_faults(models / "faults.xmi", elements)
    generate(models, tmp_path / "generated")
    for name, body in {"Stuck": STUCK, "Drift": DRIFT, "Loss": LOSS}.items():
        write_body(tmp_path / "generated" / "fault_effects.py", f"{name}.apply", body)
    monkeypatch.setattr(simulation, "TYPES", dict(simulation.fault_types(faults)))
    own = {"stuck": stuck, "drift": drift, "loss": loss}
    twins = Twins(models, tmp_path / "generated", own)

    for name in elements:
        values = twins.code.pool[name].values
        twins.fly((TimedFault(name, 20, 60, values), TimedFault(name, 70, 90, values)), 1)
    every = [
        TimedFault(name, 30 - n, 60, twins.code.pool[name].values) for n, name in enumerate(own)
    ]
    twins.fly(tuple(every), 2)
