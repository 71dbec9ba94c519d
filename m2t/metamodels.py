"""The two metamodels, loaded dynamically from their ``.ecore`` files."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from m2t.metamodel_fault_types import read_fault_types
from m2t.metamodel_reader import MetamodelReader
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import FaultType

MISSION_FILE = "mission.ecore"
FAULTS_FILE = "faults.ecore"
MISSION_ROOT = "Mission"
FAULTS_ROOT = "FaultSpecification"


@dataclass(frozen=True, slots=True)
class Metamodels:
    """The packages ``mission`` and ``faults`` as pyecore objects, and the fault types by name."""

    mission: Any
    faults: Any
    fault_types: Mapping[str, FaultType]

    @property
    def mission_class(self) -> Any:
        """Class of the root of a mission model."""
        return self.mission.getEClassifier(MISSION_ROOT)

    @property
    def faults_class(self) -> Any:
        """Class of the root of a fault model."""
        return self.faults.getEClassifier(FAULTS_ROOT)

    @property
    def packages(self) -> tuple[Any, Any]:
        """Both packages, the one that the other refers to first."""
        return (self.mission, self.faults)


def metamodel_folder() -> Path:
    """Return the folder that the variable ``MRSFI_METAMODELS`` names, or else the installed one."""
    chosen = os.environ.get("MRSFI_METAMODELS")
    return Path(chosen) if chosen else installed_metamodels()


def installed_metamodels() -> Path:
    """Return the folder of our metamodels: inside the installed package or in the source tree.

    If neither place has them, that is a ``ModelError``.
    """
    here = Path(__file__).resolve().parent
    candidates = (here / "metamodels", here.parent / "metamodels")
    for folder in candidates:
        if (folder / MISSION_FILE).is_file() and (folder / FAULTS_FILE).is_file():
            return folder
    places = " and ".join(str(folder) for folder in candidates)
    raise ModelError(
        f"{MISSION_FILE} and {FAULTS_FILE} are missing in {places}; install mrsfi again"
    )


def load_metamodels() -> Metamodels:
    """Load both metamodels of ``metamodel_folder``, once per process and folder.

    Files that are missing or cannot be used are a ``ModelError``.
    """
    return read_metamodels(metamodel_folder())


@cache
def read_metamodels(folder: Path) -> Metamodels:
    """Read ``mission.ecore`` and ``faults.ecore`` from a folder, once.

    All that is wrong with the files, one defect a line, is a ``ModelError``.
    """
    reader = MetamodelReader()
    mission = reader.read(folder / MISSION_FILE, MISSION_ROOT)
    faults = reader.read(folder / FAULTS_FILE, FAULTS_ROOT)
    types = read_fault_types(faults, reader.report)
    reader.report.require_no_errors()
    return Metamodels(mission, faults, types)


def meaning(fault_type: Any) -> FaultType:
    """Return what the metamodel says of the class of a fault type."""
    return load_metamodels().fault_types[fault_type.eClass.name]
