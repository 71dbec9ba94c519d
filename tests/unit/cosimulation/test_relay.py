"""Faults that hold commands back which are passed on, as long as they act."""

from dataclasses import replace

import pytest

from mrsfi_runtime.cosimulation.node_speech import Relay, held_commands
from mrsfi_runtime.kernel.injections import plan
from mrsfi_runtime.model.faults import Event, TimedFault, Trigger
from tests.support.fault_types import FAULT_TYPES
from tests.support.search import paper_mission, pool_of

MISSION = paper_mission()


def commanded(mission):
    """Return a mission whose first message is sent by the server, to r1."""
    goals = [*mission.goals]
    message = replace(goals[0].messages[0], sender="sv1", receiver="r1")
    goals[0] = replace(goals[0], messages=(message, *goals[0].messages[1:]))
    return replace(mission, goals=tuple(goals)), message.id


WINDOW = (2, 9)


@pytest.mark.parametrize(
    ("kind", "ticks", "trigger", "fired", "lost", "late"),
    [
        ("BlockMessage", 3.0, "", -1, [2, 3, 4], {}),
        ("BlockMessage", 3.0, "low", -1, [], {}),
        ("BlockMessage", 3.0, "low", 4, [6, 7, 8], {}),
        ("BlockMessage", 3.0, "low", 0, [2, 3, 4], {}),
        ("BlockMessage", 3.0, "low", 7, [9], {}),
        ("DelayMessage", 2.0, "", -1, [2, 3], {4: 2, 5: 3, 6: 4, 7: 5, 8: 6, 9: 7}),
        ("DelayMessage", 2.0, "low", 4, [6, 7], {8: 6, 9: 7}),
        ("DelayMessage", 0.0, "low", 4, [], {}),
    ],
)
def test_commands_are_held_back_from_when_a_fault_acts_to_when_it_ends(
    kind, ticks, trigger, fired, lost, late
):
    """Without a trigger at the ticks of the window; else from one later than the next tick on."""
    mission, message = commanded(MISSION)
    fault = replace(pool_of()["f2"], kind=FAULT_TYPES[kind], target=message, values=(ticks,))
    triggers = (Trigger("low", Event.VIOLATED, ("g3",), delay=1),)
    pool = replace(pool_of(), faults=(fault,), triggers=triggers)
    specification = (TimedFault("f2", *WINDOW, (ticks,), trigger),)
    laid_out, heard = plan(mission, pool, specification), []
    relay = Relay({"/arm": (0, heard.append)})
    relay.begin([*held_commands(mission, pool, specification)])

    for tick in range(12):
        if trigger and tick == fired:
            laid_out.triggers[0].fired = fired
        relay.take("/arm", tick)
        relay.pass_on(laid_out, tick)

    assert heard == [late.get(tick, tick) for tick in range(12) if tick not in lost]
    assert laid_out.tallies[0].applied == len([*lost, *late])
