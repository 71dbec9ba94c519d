"""The page's minimal simulator, mutilated: it counts honestly, but leaves out, or lies."""

import pytest

from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep
from mrsfi_runtime.errors import ProtocolError
from tests.support.page_simulator import join_page_simulator
from tests.support.world import paper_code
from tests.unit.cosimulation.bus import PATIENCE, QueuedBus
from tests.unit.cosimulation.test_bus_lockstep import BusEngine

CODE = paper_code(40)
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


def flown(found="", replaced=""):
    """Return the outcome of a flight on the page's simulator with a text in it replaced."""
    bus = QueuedBus()
    try:
        join_page_simulator(bus.join(), found, replaced)
        lockstep = BusLockstep(bus.join(), CODE.mission, CODE.interface, CODE.truth, PATIENCE)
        return BusEngine(CODE, 1, lockstep).evaluate(())
    finally:
        bus.close()


def left_out(line, condition):
    return line, f"if not ({condition}): {line}"


MISSING = "the simulation has to publish it in this tick"


@pytest.mark.parametrize(
    ("edit", "problem"),
    [
        (left_out(TRUTH, "robot == 'r1' and tick > 19"), f"20: nothing on /truth/r1; {MISSING}"),
        (
            left_out(SAMPLES, "sensor == 's4' and tick > 19"),
            f"20: nothing on /r2/s4/samples; {MISSING}",
        ),
        (
            left_out(POSITION, "robot == 'r3' and tick > 19"),
            f"20: nothing on /r3/position; {MISSING}",
        ),
        (left_out(SPEED, "robot == 'r1' and tick == 20"), f"20: nothing on /r1/speed; {MISSING}"),
        (left_out(ENERGY, "tick % 2"), f"1: nothing on /r1/energy; {MISSING}"),
        (left_out(CLOCK, "tick > 19"), f"20: nothing on /clock; {MISSING}"),
        (left_out(ACTIVE, "True"), f"0: nothing on /r1/s1/active; {MISSING}"),
        (
            (TRUTH_OF_SENSOR, f"truth += [tick + 1.0, 1.0 - ({AT_20} and sensor == 's2')]"),
            "20: /r1/s2/active said True last, and the true state says False",
        ),
        (
            (
                f"{ACTIVE}\n            {TRUTH_OF_SENSOR}",
                f"on = sensor != 's1' or tick < 20; {ACTIVE.replace('True', 'on')}; {TRUTH_IF_ON}",
            ),
            "20: a message on /r1/position while the robot's GPS_POSITION sensor is off",
        ),
        ((POSITION, f"{POSITION}; tick > 19 and {POSITION}"), "20: two messages on /r1/position"),
        (
            (POSITION, POSITION.replace("robot", "robot if tick < 20 else 'r1'")),
            "20: two messages on /r1/position",
        ),
        ((CLOCK, CLOCK.replace("tick", f"tick - {AT_20}")), "20: /clock said 19 s; expected 20"),
        (
            ('[state["run"], tick,', f"[state['run'], tick - {AT_20},"),
            "20: the simulation announced tick 19; expected tick 20",
        ),
        (
            (SAMPLES, SAMPLES.replace("1)", f"1 - 9 * {AT_20})")),
            "20: /r1/s1/samples carried 12 after 20; a count never falls",
        ),
        (
            (TRUTH_OF_SENSOR, f"truth += [tick + 1.0 - 9 * {AT_20}, 1.0]"),
            "20: /truth/r1 carried count 12.0 and active 1.0 of its sensor 1 after",
        ),
        (
            (SPEED, SPEED.replace("=speed", "=speed if tick < 20 else float('nan')")),
            "20: /r1/speed carried .*nan.*; expected std_msgs/Float64",
        ),
        (
            (ENERGY, ENERGY.replace("90000.0", "'90000'")),
            "0: /r1/energy carried .*'90000'.*; expected std_msgs/Float64",
        ),
        (
            (TRUTH, TRUTH.replace("=truth", "=truth[:7]")),
            "0: /truth/r1 carried .*; expected 9 numbers",
        ),
    ],
)
def test_what_a_tick_has_to_bring_and_does_not_is_told_with_topic_and_tick(edit, problem):
    with pytest.raises(ProtocolError, match=f"^run 1, tick {problem}"):
        flown(*edit)


@pytest.mark.parametrize("told_again", ["not tick", "tick % 3 == 0"])
def test_what_need_not_be_said_again_changes_nothing(told_again):
    assert flown(ACTIVE, f"if {told_again}: {ACTIVE}") == flown()
