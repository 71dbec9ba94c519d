"""Missions in several files."""

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from m2t.models.constraints import fault_types
from m2t.models.load import LoadedFile, LoadedModels, load_mission_folder, saved
from m2t.read import Spelling
from tests.support.models.copies import copy_models

Parts = Callable[[LoadedModels], Mapping[str, tuple[Any, ...]]]

PARTS: dict[str, Parts] = {
    "robots": lambda models: {"robots.xmi": tuple(models.mission.robots)},
    "one_robot": lambda models: {"parts/r2.xmi": (models.mission.robots[1],)},
    "two_levels": lambda models: {
        "robots/robots.xmi": tuple(models.mission.robots),
        "robots/sensors/sensors.xmi": tuple(
            sensor for robot in models.mission.robots for sensor in robot.sensors
        ),
    },
    "goals_and_tasks": lambda models: {
        "goals.xmi": tuple(models.mission.goals),
        "tasks.xmi": tuple(goal.task for goal in models.mission.goals),
        "area.xmi": (models.mission.missionArea,),
        "center.xmi": (models.mission.missionArea.center,),
    },
    "faults": lambda models: {
        "pool.xmi": tuple(models.faults.faults[:5]),
        "types.xmi": fault_types(models.faults.faults[0]),
        "messages.xmi": tuple(models.mission.goals[0].messages),
    },
}


def write_split(folder: Path, models: LoadedModels, parts: Mapping[str, tuple[Any, ...]]) -> None:
    """Write loaded models with some of their elements in files of their own."""
    files = [LoadedFile(folder / name, Spelling("ASCII"), roots) for name, roots in parts.items()]
    split = dataclasses.replace(models, files=(*models.files, *files))
    for path, content in saved(split).items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def split_folder(folder: Path, parts: Parts) -> Path:
    """Copy the paper's mission below a folder, in parts, and return the copy."""
    models = load_mission_folder(copy_models(folder))
    write_split(models.mission_path.parent, models, parts(models))
    return models.mission_path.parent
