from io import StringIO

from mrsfi_runtime.kernel.flight import no_verdicts
from mrsfi_runtime.kernel.initial import initial_state
from mrsfi_runtime.record.observers import SimulationLog
from tests.support.search import paper_mission


def test_the_log_tells_what_is_so_from_the_first_tick_on():
    mission = paper_mission()
    world = initial_state(mission, 1)
    verdicts = no_verdicts(len(mission.goals))
    verdicts.is_true[0] = verdicts.missed[0] = verdicts.is_believed[2] = 1
    stream = StringIO()

    SimulationLog(mission, stream)(world, world, verdicts)

    events = [line for line in stream.getvalue().splitlines() if "event" in line]
    assert events == [
        "  event g1 violated: no -> yes",
        "  event g1 missed: no -> yes",
        "  event g3 believed violated: no -> yes",
    ]
