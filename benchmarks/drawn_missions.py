"""Missions that nobody chose: a goal of each of the nine tasks, and a fault of each of the types.

They are those of the tests, drawn by number; nothing was tuned on them, and none was left out.
"""

from pathlib import Path
from random import Random

from m2t.generate import generate
from tests.support.models.shapes import draw_mission, draw_pool, shape, write

DRAWN = ("drawn_1", "drawn_2")
"""The first two."""

_N_ROBOTS, _N_OBSTACLES, _DURATION = 3, 2, 200


def drawn_mission(place: Path, name: str) -> Path:
    """Write a mission, its campaign file ``a`` and its code; return the folder of its models.

    Its code lies in the folder ``generated`` beside ``models``, both in ``place``.
    """
    number = int(name.removeprefix("drawn_"))
    rng, of = Random(number), shape(_N_ROBOTS, _N_OBSTACLES, seed=number)
    mission = draw_mission(rng, of, longest=_DURATION, shortest=_DURATION)
    models = write(place / "models" / name, mission, draw_pool(rng, of))
    (models / "case_a.toml").write_text("[search]\n", encoding="ascii")
    generate(models, generated(models))
    return models


def generated(models: Path) -> Path:
    """Return the folder of the code of a mission, by that of its models."""
    return models.parent.parent / "generated" / models.name
