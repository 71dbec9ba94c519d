"""The project of the working folder, and the engine that options, record and project choose.

A file ``mrsfi.toml`` at the root of a project states its folders; commands find it from any folder
inside. These are the defaults; without the file, the working folder is the root::

    [project]
    metamodels = "metamodels"
    models = "models"
    generated = "generated"
    runs = "runs"
    ros = 1

A second table, ``[node]``, maps the topics of an external node (``cosimulation.node_mapping``).

``chosen`` merges options, record, project and defaults, in this order, into ``EngineSettings``;
``again`` does so for a campaign that is flown again. ``evaluator`` opens an evaluator of many
specifications.
"""

import hashlib
import json
import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass, fields
from pathlib import Path
from time import monotonic
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

from mrsfi_runtime.cosimulation.bus_topics import ANSWER, BARRIER
from mrsfi_runtime.engine.opening import named, open_engine
from mrsfi_runtime.errors import ReplayMismatch, UsageError, counted
from mrsfi_runtime.project_file import SETTINGS, root, settings
from mrsfi_runtime.record.engine_settings import (
    AUTO,
    BOTH,
    BUILT_IN,
    CI,
    COMPILED,
    INJECTOR,
    OF_ANY_ENGINE,
    ON_A_BUS,
    REFERENCE,
    RESTART,
    ROS2,
    ROSBRIDGE,
    SERVICE,
    EngineSettings,
    Workers,
    flag,
)
from mrsfi_runtime.transport.topics import ROS_VERSIONS

if TYPE_CHECKING:
    from mrsfi_runtime.engine.flights import Engine, Evaluator
    from mrsfi_runtime.generated_code import MissionCode


@dataclass(frozen=True, slots=True)
class Project:
    """The folders of a project, each as short as a user would write it.

    ``ros`` is the ROS version of its rosbridge server, ``node`` the table of its external node,
    ``fmea`` the team's numbers.
    """

    models: Path
    generated: Path
    runs: Path
    ros: int
    node: Mapping[str, Any] | None
    fmea: Mapping[str, Mapping[str, Any]]


def project() -> Project:
    """Return the project of the working folder.

    Settings that cannot be read, or have no meaning, are a ``UsageError``.
    """
    file = root() / SETTINGS
    given, node, fmea = settings(file) if file.is_file() else ({}, None, {})
    ros = given.get("ros", 1)
    if type(ros) is not int or ros not in ROS_VERSIONS:
        raise UsageError(f"{file}: found ros = {ros!r}; expected 1 or 2")
    models, generated, runs = (
        from_here(file.parent / given.get(name, name)) for name in ("models", "generated", "runs")
    )
    return Project(models, generated, runs, ros, node, fmea)


def from_here(path: Path) -> Path:
    """Return a path as short as a user would write it: relative if that is shorter."""
    relative = Path(os.path.relpath(path))
    return relative if len(relative.parts) < len(path.parts) else path


Tell: TypeAlias = Callable[[str], None]
"""Receives a line of progress."""

Given: TypeAlias = Mapping[str, Any]
"""Fields of ``EngineSettings`` that options give, by name."""

AS_RECORDED: Given = MappingProxyType({})
"""No options: the engine is that of the record."""

_NO_SOURCE = re.compile(r"/(\.[^./]|__pycache__/|node_modules/)|\.log$")
"""Hidden files and folders, caches and logs, in a path that begins with a slash."""


def silent(_: str) -> None:
    """Ignore a line of progress."""


_EVERY = 2.0  # seconds between two lines of progress


def now_and_then(tell: Tell) -> Callable[[Callable[[], str]], None]:
    """Return a function that tells what a function returns, every two seconds at most from now."""
    told = monotonic()

    def tell_of(words: Callable[[], str]) -> None:
        nonlocal told
        if (now := monotonic()) - told > _EVERY:
            told = now
            tell(words())

    return tell_of


def again(given: Given, recorded: EngineSettings, default: str = AUTO) -> EngineSettings:
    """Return the engine for flying a campaign again: any of mrsfi, or the same external parts.

    A campaign whose flights do not repeat themselves is a ``ReplayMismatch``.
    """
    if recorded.unrepeated:
        raise ReplayMismatch(
            f"this campaign cannot be flown again: {recorded.unrepeated}; to fly one of its "
            "specifications in a new flight: mrsfi simulate MISSION --faults FILE"
        )
    return chosen(given, default, recorded if recorded.is_foreign else EngineSettings(default))


def chosen(
    given: Given, default: str = REFERENCE, recorded: EngineSettings | None = None
) -> EngineSettings:
    """Return the settings: options before the record, the project and the defaults.

    Options that contradict each other, or parts that differ from the record's, are a
    ``UsageError``; a node that differs from the record's is a ``RecordError``.
    """
    values = _merged(given, recorded or EngineSettings(default))
    side, url, parts = values.get("side", BOTH), values.get("url"), EngineSettings(**values).parts
    if recorded is not None and parts != recorded.parts:
        place = "--url URL" if recorded.world_command is None else "--world COMMAND"
        options = f"--engine {ROSBRIDGE} --side {recorded.side} {place}, or none of them"
        if not recorded.is_foreign:
            options = "no --side; to fly its weaknesses in another world: mrsfi confirm"
        found = f"this campaign was flown with {recorded.parts}; found {parts}"
        raise UsageError(f"{found}, which counts differently; expected {options}")
    if values.get("world") not in {None, BUILT_IN}:
        values["world_sha256"] = _files_beside(values["world"])
    if side == INJECTOR:
        command, table = values.get("node"), project().node
        values = {
            "node_pace": BARRIER if url is None else ANSWER,
            "node_reset": SERVICE if command is None else RESTART,
            **values,  # then the files and the table of the node as they are today
            "node_mapping": "" if table is None else json.dumps(table, sort_keys=True),
            "node_sha256": _files_beside(command or ""),
        }
    settings = EngineSettings(**values)
    settings.require_sense()
    if side != INJECTOR:
        _require_none(given, "node", f"needs --side {INJECTOR}")
    if settings.world_command is None:
        _require_none(given, "world_reset", "needs --world COMMAND")
    if recorded is not None:
        settings.require_same_parts(recorded)
    return settings


def _merged(given: Given, base: EngineSettings) -> dict[str, Any]:
    """Return the fields that options, or else a record or the project give."""
    is_foreign = given.get("side") == INJECTOR or not given.keys().isdisjoint({"world", "domain"})
    bus = ROS2 if "domain" in given else ROSBRIDGE
    name = given.get("name") or (bus if is_foreign else base.name)
    known = {
        each.name: getattr(base, each.name)
        for each in fields(base)
        if each.name in OF_ANY_ENGINE or (base.name == name and name in ON_A_BUS)
    }
    if name not in ON_A_BUS:
        _require_none(given, "", f"needs --engine {ROSBRIDGE}; the {name} engine has no bus")
    elif "ros" not in known:
        known["ros"] = project().ros
    if name == ROS2:
        known["side"] = INJECTOR  # the others have no messages of ROS 2
    elif given.get("world", BUILT_IN) != BUILT_IN and known.get("side", BOTH) == BOTH:
        known["side"] = CI
    return {**known, **given, "name": name}


def _require_none(given: Given, group: str, needs: str) -> None:
    """Refuse options of fields whose names begin with a group's."""
    for each in fields(EngineSettings):
        is_of_group = each.name.startswith(group) and each.name not in OF_ANY_ENGINE
        if is_of_group and each.name in given:
            raise UsageError(f"{flag(each)} {needs}")


def _files_beside(command: str) -> tuple[str, ...]:
    """Return the files that a command depends on, each followed by its hash.

    These are the files that it names, those beside them and below, and Python modules in the
    folders above. Files of the working folder count only if they are named, because the project is
    there; absolute paths, hidden files, logs and caches do not count.
    """
    import shlex  # noqa: PLC0415 - slow, and seldom needed

    found = set[Path]()
    with suppress(ValueError):  # the command cannot be split
        for path in map(Path, shlex.split(command)):
            if path.is_file() and not path.is_absolute():
                found |= {path, *(() if path.parent == Path() else path.parent.rglob("*"))}
                found.update(*(folder.glob("*.py") for folder in path.parents[1:-1]))
    return tuple(
        f"{path.as_posix()} {hashlib.sha256(path.read_bytes()).hexdigest()}"
        for path in sorted(found)
        if path.is_file() and not _NO_SOURCE.search(f"/{path.as_posix()}")
    )


def own_engine(
    evaluator: "Evaluator", code: "MissionCode", seed: int, settings: EngineSettings
) -> "AbstractContextManager[Engine]":
    """Return an engine in this process to enter: that of an evaluator, or a new one like it."""
    from mrsfi_runtime.engine.flights import Engine  # noqa: PLC0415 - not for --help

    if isinstance(evaluator, Engine):
        return nullcontext(evaluator)
    return open_engine(settings, code, seed)


@contextmanager
def evaluator(
    code: "MissionCode",
    seed: int,
    engine: EngineSettings,
    workers: Workers,
    tell: Tell = silent,
    on_reached: Tell = silent,
) -> "Iterator[Evaluator]":
    """Yield an evaluator of specifications of a mission while the body runs.

    ``seed`` is the default mission seed. With the URL of a server there is one worker by default.
    ``tell`` receives what does not compile; ``on_reached`` receives the number of workers before
    they get the mission. A cluster that is out of reach or without workers is a
    ``TransportError``.
    """
    workers.require_sense(engine)
    if workers.dask is None:
        n_workers = workers.count(engine)
        on_reached(counted(n_workers, "workers"))
        engine = named(engine, code, seed, tell)
        if n_workers == 1 or engine.name == COMPILED:  # one process, with threads if compiled
            with open_engine(engine, code, seed, n_workers) as own:
                yield own
            return
        from mrsfi_runtime.engine.pools import WorkerPool  # noqa: PLC0415 - brings processes

        with WorkerPool(code, seed, n_workers, engine) as pool:
            yield pool
        return
    from mrsfi_runtime.engine.cluster import ClusterPool  # noqa: PLC0415 - optional

    n_local = workers.count(engine)
    with ClusterPool(workers.dask, n_local, code, seed, engine, on_reached) as many:
        yield many


@contextmanager
def flying(
    code: "MissionCode", seed: int, engine: EngineSettings, workers: Workers, tell: Tell = silent
) -> "Iterator[tuple[Evaluator, Engine]]":
    """Yield an evaluator of specifications, and an engine in this process for all else."""
    with (
        evaluator(code, seed, engine, workers, tell) as many,
        own_engine(many, code, seed, engine) as own,
    ):
        yield many, own
