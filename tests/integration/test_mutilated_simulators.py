"""The page's minimal simulator: as it stands where messages overtake, and where it lies."""

from contextlib import closing

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import ServerSettings, TypeTable
from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep
from mrsfi_runtime.cosimulation.bus_topics import Patience
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport
from mrsfi_runtime.transport.topics import ROS_VERSIONS
from tests.support.page_simulator import join_page_simulator
from tests.support.two_sides import BusEngine
from tests.support.world import paper_code

CODE = paper_code(36)
PATIENCE = Patience(tick=3.0, handshake=10.0)
POSITION = 'publish(f"/{robot}/position", x=at[0], y=at[1], z=0.0)'
SPEED = 'publish(f"/{robot}/speed", data=speed)'
ENERGY = 'publish(f"/{robot}/energy", data=90000.0)'
SAMPLES = 'publish(f"/{robot}/{sensor}/samples", data=tick + 1)'
ACTIVE = 'publish(f"/{robot}/{sensor}/active", data=True)'
TRUTH = 'publish(f"/truth/{robot}", data=truth)'
TRUTH_OF_SENSOR = "truth += [tick + 1.0, 1.0]"
TRUTH_IF_ON = "truth += [tick + 1.0, float(on)]"
CLOCK = 'publish("/clock", clock={"secs": tick, "nsecs": 0})'
AT_20 = "(tick == 20)"


@pytest.fixture(params=ROS_VERSIONS)
def ros(request):
    return request.param


def flown(ros, found="", replaced=""):
    """Return the outcome of a flight on the page's simulator with a text in it replaced."""
    with (
        EmbeddedBridge(ServerSettings(types=TypeTable(ros=ros))) as server,
        closing(EmbeddedTransport(server)) as theirs,
        closing(EmbeddedTransport(server)) as ours,
    ):
        join_page_simulator(theirs, found, replaced)
        lockstep = BusLockstep(ours, CODE.mission, CODE.interface, CODE.truth, PATIENCE)
        return BusEngine(CODE, 1, lockstep).evaluate(())


MISSING = "the simulation must send one in this tick"


@pytest.mark.parametrize(
    ("edit", "problem"),
    [
        *(
            ((line, f"if not ({when}): {line}"), f"{tick}: no message on {topic}; {MISSING}")
            for line, when, tick, topic in (
                (TRUTH, "robot == 'r1' and tick > 19", 20, "/truth/r1"),
                (SAMPLES, "sensor == 's4' and tick > 19", 20, "/r2/s4/samples"),
                (POSITION, "robot == 'r3' and tick > 19", 20, "/r3/position"),
                (SPEED, "robot == 'r1' and tick == 20", 20, "/r1/speed"),
                (ENERGY, "tick % 2", 1, "/r1/energy"),
                (CLOCK, "tick > 19", 20, "/clock"),
                (ACTIVE, "True", 0, "/r1/s1/active"),
            )
        ),
        (
            (TRUTH_OF_SENSOR, f"truth += [tick + 1.0, 1.0 - ({AT_20} and sensor == 's2')]"),
            "20: the last message on /r1/s2/active was True, but the true state is False",
        ),
        (
            (
                f"{ACTIVE}\n            {TRUTH_OF_SENSOR}",
                f"on = sensor != 's1' or tick < 20; {ACTIVE.replace('True', 'on')}; {TRUTH_IF_ON}",
            ),
            "20: a message arrived on /r1/position while the robot's GPS_POSITION sensor is off",
        ),
        (
            (POSITION, POSITION.replace("robot", "robot if tick < 20 else 'r1'")),
            "20: two messages arrived on /r1/position",
        ),
        ((CLOCK, CLOCK.replace("tick", f"tick - {AT_20}")), "20: /clock carried 19 s; expected 20"),
        (
            (SAMPLES, SAMPLES.replace("1)", f"1 - 9 * {AT_20})")),
            "20: /r1/s1/samples carried 12 after 20; expected no decrease",
        ),
    ],
)
def test_what_a_tick_has_to_bring_and_does_not_is_told_with_topic_and_tick(ros, edit, problem):
    with pytest.raises(ProtocolError, match=f"^run 1, tick {problem}"):
        flown(ros, *edit)


@pytest.mark.parametrize("told_again", ["not tick", "tick % 3 == 0"])
def test_what_need_not_be_said_again_changes_nothing(ros, told_again):
    assert flown(ros, ACTIVE, f"if {told_again}: {ACTIVE}") == flown(ros)
