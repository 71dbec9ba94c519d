"""The paper's mission and fault pool, built from the vocabulary, and a stand-in evaluation."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

from mrsfi_runtime.api import AvoidCollision, GatherSamples, StayWithinMissionArea, SufficientEnergy
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification
from mrsfi_runtime.model.mission import (
    Area,
    Battery,
    Coordinates,
    Goal,
    Message,
    MessageData,
    Mission,
    MotionSource,
    Obstacle,
    Robot,
    Sensor,
    Server,
)
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.campaign import Evaluation, FailedEvaluation, Generation
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from tests.support.fault_types import FAULT_TYPES

OBSTACLES = (
    ("o1", 0, 500, 50),
    ("o2", 500, 500, 40),
    ("o3", 500, 0, 45),
    ("o4", 500, -500, 25),
    ("o5", 0, -500, 30),
    ("o6", -500, -500, 28),
    ("o7", -500, 0, 45),
    ("o8", -500, 500, 15),
)
POSITION = (MessageData("POSITION", "Coordinates"),)
REPORT = (*POSITION, MessageData("SPEED", "Int"), MessageData("ENERGY", "Double"))
MEMBERS = ("r2", "r3", "r1")


def paper_mission(duration: int = 1000) -> Mission:
    return Mission(
        name="uuv_sampling",
        duration=duration,
        area=Area("a15", Coordinates(), 2000.0),
        robots=(
            _robot("r1", (250.0, -250.0), 5.0, ("s1", "s2"), "PRESSURE", (20000.0, 80000.0)),
            _robot("r2", (-250.0, 250.0), 4.0, ("s3", "s4"), "TEMPERATURE", (4000.0, 60000.0)),
            _robot("r3", (250.0, 250.0), 4.0, ("s5", "s6"), "DEPTH", (50000.0, 50000.0)),
        ),
        servers=(Server("sv1", "server"),),
        obstacles=tuple(
            Obstacle(o, Area(f"{o}.area", Coordinates(x, y, 1.0), r)) for o, x, y, r in OBSTACLES
        ),
        goals=(
            _goal("g1", AvoidCollision(MEMBERS, tuple(o[0] for o in OBSTACLES)), 1, POSITION),
            _goal("g2", StayWithinMissionArea(), 4, POSITION),
            _goal("g3", SufficientEnergy(), 7, REPORT),
            _sampling_goal("g4", "r2", "s4", 250, "m10", "TEMPERATURE"),
            _sampling_goal("g5", "r3", "s6", 400, "m11", "DEPTH"),
            _sampling_goal("g6", "r1", "s2", 500, "m12", "PRESSURE"),
        ),
    )


def _robot(
    robot: str,
    position: tuple[float, float],
    speed: float,
    sensors: tuple[str, str],
    sensor_type: str,
    energies: tuple[float, float],
) -> Robot:
    return Robot(
        id=robot,
        name=robot,
        position=Coordinates(*position, 1.0),
        speed=speed,
        sensors=(
            Sensor(sensors[0], "gps", "GPS_POSITION", 2.0, 5),
            Sensor(sensors[1], "sampler", sensor_type, 2.0, 5),
        ),
        batteries=tuple(Battery(f"{robot}.b{i}", "b", e) for i, e in enumerate(energies)),
        motion_sources=(MotionSource(f"{robot}.ms", "ms", 5.0),),
    )


def _goal(goal: str, task: object, first_message: int, body: tuple[MessageData, ...]) -> Goal:
    return Goal(
        id=goal,
        name=goal,
        members=MEMBERS,
        task=task,
        messages=tuple(
            Message(f"m{number}", robot, "sv1", body)
            for number, robot in enumerate(MEMBERS, first_message)
        ),
    )


def _sampling_goal(
    goal: str, robot: str, sensor: str, target: int, message: str, sensor_type: str
) -> Goal:
    return Goal(
        id=goal,
        name=goal,
        members=(robot,),
        task=GatherSamples(target, sensor),
        messages=(Message(message, robot, "sv1", (MessageData(sensor_type, "Double"),)),),
    )


PAPER_FAULTS = tuple(
    Fault(id=f"f{number}", kind=FAULT_TYPES[kind], target=target, values=tuple(map(float, values)))
    for number, (kind, target, *values) in enumerate(
        (
            ("ActivateSensor", "s2"),
            ("BlockMessage", "m4", 5),
            ("DeactivateSensor", "s5"),
            ("DecrementRemainingEnergyCapacityReport", "m8", 10),
            ("DecrementSampleRate", "m11", 2),
            ("DecrementSensorEnergyPerSample", "m9", 10),
            ("DecrementSpeed", "m7", 1),
            ("DelayMessage", "m10", 200),
            ("FixedObstacleCoordinates", "o5", 200, -450, 1),
            ("FixedRemainingEnergyCapacityReport", "m8", 150),
            ("FixedRobotCoordinates", "m2", 1200, -800, 1),
            ("FixedSampleRate", "m8", 120),
            ("FixedSensorEnergyPerSample", "m9", 10),
            ("FixedSpeed", "m7", 50),
            ("IncrementRemainingEnergyCapacityReport", "m8", 10),
            ("IncrementSampleRate", "m11", 25),
            ("IncrementSensorEnergyPerSample", "m7", 22),
            ("IncrementSpeed", "m7", 10),
            ("RandomObstacleCoordinates", "o2"),
            ("RandomRemainingEnergyCapacityReport", "m8", 255, 1000),
            ("RandomRobotCoordinates", "m3"),
            ("RandomSampleRate", "m10", 1, 50),
            ("RandomSensorEnergyPerSample", "m7", 11, 30),
            ("RandomSpeed", "m8", -8, 8),
            ("StartRobot", "r3"),
            ("StopRobot", "r1"),
            ("ZeroRemainingEnergyCapacityReport", "m8"),
            ("ZeroSampleRate", "m12"),
            ("ZeroSensorEnergyPerSample", "m7"),
            ("ZeroSpeed", "m9"),
        ),
        start=1,
    )
)


def pool_of(*fault_ids: str) -> FaultPool:
    """Return the paper's pool, or only some of its faults in the order given."""
    faults = {fault.id: fault for fault in PAPER_FAULTS}
    return FaultPool("fs", tuple(faults[f] for f in fault_ids) if fault_ids else PAPER_FAULTS)


def paper_space(duration: int = 1000, *fault_ids: str) -> SearchSpace:
    return SearchSpace.of(paper_mission(duration), pool_of(*fault_ids))


def random_pair(space: SearchSpace, n_faults: int, rng: Random) -> tuple[Specification, ...]:
    return (
        random_specification(space, n_faults, rng),
        random_specification(space, n_faults, rng),
    )


def outcome_of(*believed: int) -> Outcome:
    zeros = (0,) * len(believed)
    return Outcome(believed, believed, zeros, zeros, zeros, (), (), "")


def stand_in_outcome(specification: Specification) -> Outcome:
    """Return violations that are a plain function of a specification: long windows are bad."""
    believed = [0] * 6
    for timed in specification:
        number = int(timed.fault[1:])
        believed[number % 6] += timed.finish - timed.start + 1
    return outcome_of(*(min(1000, violations) for violations in believed))


def evaluate_stand_in(specifications: Sequence[Specification]) -> list[Outcome]:
    return [stand_in_outcome(specification) for specification in specifications]


@dataclass
class MemoryRecorder:
    """Keeps a campaign in memory under the rules of ``CampaignStore``."""

    kept: list[Evaluation] = field(default_factory=list)
    failed: list[FailedEvaluation] = field(default_factory=list)
    generations: list[Generation] = field(default_factory=list)
    n_appends: int = field(default=0, compare=False)

    @property
    def n_evaluations(self) -> int:
        return len(self.kept)

    def evaluations(self, first: int = 0, n_most: int | None = None) -> Sequence[Evaluation]:
        return self.kept[first:][:n_most]

    def failures(self) -> Sequence[FailedEvaluation]:
        return self.failed

    def generation(self, index: int) -> Generation | None:
        return self.generations[index] if index < len(self.generations) else None

    def append(
        self,
        evaluations: Sequence[Evaluation],
        failures: Sequence[FailedEvaluation],
        generations: Sequence[Generation],
    ) -> None:
        for evaluation in evaluations:
            if evaluation.index != len(self.kept):
                message = f"found {evaluation.index}; expected {len(self.kept)}"
                raise ValueError(message)
            self.kept.append(evaluation)
        self.failed.extend(failures)
        for generation in generations:
            if generation.index != len(self.generations):
                message = f"found {generation.index}; expected {len(self.generations)}"
                raise ValueError(message)
            self.generations.append(generation)
        self.n_appends += 1
