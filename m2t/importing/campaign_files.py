"""Campaign files that an imported mission begins with: the paper's two cases."""

from typing import Any

_CASE = """\
# Written by `mrsfi import`. {about}

[search]
algorithm = "paper"      # paper | random | drift
population = 20
generations = 50
faults = 20
crossover = 0.7
mutation = 0.7
selection = "roulette"
{fitness}
seed = 1
mission_seed = 1
"""

_ABOUT_A = "Case study A of the paper (section V-B 1): fitness function (1)."
_FITNESS_A = """\
fitness = "weighted"     # equation (1): 0.3 x all violations + 0.7 x distinct violated goals"""

_ABOUT_B = """\
Case study B of the paper (section V-B 1): fitness function (2)
# on one collision-focused and one energy-focused goal."""
_FITNESS_B = """\
fitness = "focused"      # equation (2): violations of the chosen goals
goals = [{goals}]"""


def campaign_files(mission: Any) -> dict[str, bytes]:
    """Return the campaign files of a mission by name: ``case_a.toml``, and maybe ``case_b.toml``.

    Case b takes both a goal that avoids collisions and one about energy; it names the first each.
    """
    files = {"case_a.toml": _case(_ABOUT_A, _FITNESS_A)}
    firsts = [_first(mission, "AvoidCollision"), _first(mission, "SufficientEnergy")]
    goals = [goal for goal in firsts if goal is not None]
    if len(goals) == len(firsts):
        listed = ", ".join(f'"{goal}"' for goal in goals)
        files["case_b.toml"] = _case(_ABOUT_B, _FITNESS_B.format(goals=listed))
    return files


def _case(about: str, fitness: str) -> bytes:
    return _CASE.format(about=about, fitness=fitness).encode("ascii")


def _first(mission: Any, task: str) -> str | None:
    """Return the ID of the first goal with a task; IDs need no quoting in TOML."""
    found = (goal.ID for goal in mission.goals if goal.task.eClass.name == task)
    return next(found, None)
