"""Missions in the Python API: scripts begin here.

``load`` returns a ``Mission``. Its methods check their arguments and call the module of each task,
which they import when they are called, so that ``import mrsfi`` stays quick. They fly the generated
code, which has to be fresh.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import fields, replace
from functools import cached_property, partial
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING

from mrsfi.engines import Tell, evaluator, silent
from mrsfi.folders import MissionFolders, campaign_file, find_mission, load_fresh
from mrsfi.generating import generate, rename
from mrsfi.loading import read_specification
from mrsfi_runtime.engine.opening import open_engine, tried
from mrsfi_runtime.errors import Diagnostic, UsageError
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification, TimedFault, timed_fault
from mrsfi_runtime.project_file import choose_metamodels
from mrsfi_runtime.record.engine_settings import AUTO, REFERENCE, EngineSettings, Workers
from mrsfi_runtime.record.settings import CampaignSettings, require_seed, require_whole

if TYPE_CHECKING:
    from mrsfi.campaign import Campaign
    from mrsfi.flight import Flight
    from mrsfi.regressions import Checked
    from mrsfi_runtime.generated_code import MissionCode
    from mrsfi_runtime.model.mission import Evaluated
    from mrsfi_runtime.model.mission import Mission as Model
    from mrsfi_runtime.search.run import CampaignProgress
    from mrsfi_runtime.study.comparison import Comparison, RunResult, Variant


def load(mission: str | Path, generated: Path | str | None = None) -> "Mission":
    """Return a mission by its name in ``models``, or by its folder.

    Parameters
    ----------
    mission
        Name of a folder under ``models`` of the working folder, or the path of a mission folder.
    generated
        Folder of its generated code, if it is not ``generated/NAME`` beside ``models``.

    Raises
    ------
    UsageError
        If there is no such mission.
    """
    choose_metamodels()
    return Mission(find_mission(str(mission), _path("generated", generated)))


class Mission:
    """A mission: its models, and the code that was generated from them. Use ``load``.

    The generated code flies; it has to follow from the models. ``generate`` brings it up to date.

    Attributes
    ----------
    folders
        The folders of models and generated code.
    """

    def __init__(self, folders: MissionFolders) -> None:
        self.folders = folders

    def __repr__(self) -> str:
        return f"<Mission {self.name} in {self.folders.models}>"

    def _repr_html_(self) -> str:
        from mrsfi_runtime.analysis.tables import mission_table, to_html  # noqa: PLC0415 - as above

        return to_html(mission_table(self.name, self.model, self.pool))

    @property
    def name(self) -> str:
        """Name of its folder."""
        return self.folders.name

    @cached_property
    def code(self) -> "MissionCode":
        """The generated code, loaded when it is first asked for.

        Raises
        ------
        GenerationError
            If it is stale, or not generated yet.
        EvaluationError
            If a region is not sound, or the code cannot be loaded.
        """
        return load_fresh(self.folders)

    @property
    def model(self) -> "Model":
        """The mission as modelled: robots, obstacles, messages, goals, duration."""
        return self.code.mission

    @property
    def pool(self) -> FaultPool:
        """The faults that could occur in it."""
        return self.code.pool

    def validate(self, tell: Tell = silent) -> tuple[Diagnostic, ...]:
        """Return the defects of models and code, as ``mrsfi validate`` does.

        Parameters
        ----------
        tell
            Receives the reason if the mission is not flown without faults.
        """
        from mrsfi.loading import validate  # noqa: PLC0415 - brings numpy

        return validate(str(self.folders.models), self.folders.generated, tell).diagnostics

    def generate(self, *, force: bool = False) -> tuple[str, ...]:
        """Bring the generated code up to date, and return the names of the files that changed.

        Parameters
        ----------
        force
            Overwrite edits outside protected regions.

        Raises
        ------
        ModelError
            If the models are not sound.
        GenerationError, ProtectedRegionError
            If hand-written code would be lost.
        """
        done = generate(self.folders.models, self.folders.generated, force=force)
        self.__dict__.pop("code", None)
        return (*done.written, *done.removed)

    def rename(self, names: Mapping[str, str]) -> tuple[Path, ...]:
        """Give elements other IDs, everywhere, and return the files that changed.

        Parameters
        ----------
        names
            New IDs by old ones, of elements of the mission and of its pool; all change at once.

        Raises
        ------
        UsageError
            If an old ID is unknown, a new one is invalid or taken, or a file cannot be edited.
        ModelError
            If the models, or a specification beside them, are not sound.
        GenerationError
            If generated code is stale, or was edited outside its regions.
        """
        renamed = rename(self.folders, names)
        self.__dict__.pop("code", None)
        return renamed.paths

    def timed(
        self, fault: str, start: int, finish: int, *, trigger: str = "", **values: float
    ) -> TimedFault:
        """Return a fault of the pool with a window and values.

        Parameters
        ----------
        fault
            Its ID.
        start, finish
            First and last tick at which it is active.
        trigger
            ID of the pool's trigger that it waits for in this window, if any.
        values
            Values that replace those of the pool's fault, such as ``VAL=3``.

        Raises
        ------
        SpecificationError
            If the pool has no such fault, or the fault no such parameter, window or value.
        """
        found = self.pool[fault]
        usual = found.kind.named(found.values)
        timed = timed_fault(fault, found.kind, start, finish, usual | values)
        return timed._replace(trigger=trigger)

    def fly(
        self,
        faults: Path | str | Iterable[TimedFault] = (),
        seed: int = 1,
        engine: str | EngineSettings = REFERENCE,
    ) -> "Flight":
        """Fly once, and return every tick.

        Parameters
        ----------
        faults
            As ``timed`` returns them, or the file of a fault specification; none if left out.
        seed
            Mission seed: decides which samples are valid.
        engine
            ``reference``, ``compiled``, ``auto`` or ``rosbridge``, or settings in detail.

        Raises
        ------
        SpecificationError
            If a fault is unknown, or conflicting ones overlap.
        EvaluationError
            If the code of a region fails.
        """
        from mrsfi.flight import fly  # noqa: PLC0415 - brings numpy

        seed = require_seed(seed)
        if isinstance(faults, Path | str):
            written = read_specification(Path(faults), self.code)
            pool, specification = written.pool, written.specification
        else:
            pool, specification = self.pool, Gate(self.model, self.pool).admitted(faults)
        with open_engine(_settings(engine), self.code, seed) as flown_by:
            return fly(flown_by, pool, specification, seed)

    def evaluate(
        self,
        specifications: Sequence[Specification],
        seed: int = 1,
        engine: str | EngineSettings = AUTO,
        workers: int | None = None,
    ) -> "Iterator[Evaluated]":
        """Fly many times, and yield the outcomes in the same order as they come.

        Parameters
        ----------
        specifications
            Timed faults of the pool, for each flight.
        seed
            Mission seed of all of them.
        engine
            As ``fly`` takes it.
        workers
            Processes; as many as there are processors if left out.

        Yields
        ------
        Outcome or FailedFlight
            The second if the code of a region failed.
        """
        seed, settings, n_workers = require_seed(seed), _settings(engine), _workers(workers)

        def flown() -> "Iterator[Evaluated]":
            with evaluator(self.code, seed, settings, n_workers) as many:
                yield from many.evaluate_many(specifications, seed)

        return flown()

    def evolve(
        self,
        case: str | None = None,
        *,
        out: Path | str | None = None,
        engine: str | EngineSettings = AUTO,
        workers: int | None = None,
        dask: str | None = None,
        explain: bool = True,
        progress: "Callable[[CampaignProgress], None]" = lambda _: None,
        tell: Tell = silent,
        **settings: object,
    ) -> "Campaign":
        """Search for faults that break the goals of the mission, and find its weaknesses.

        Parameters
        ----------
        case
            ``a`` for ``case_a.toml`` beside the models, and so on, or the path of a campaign file;
            the paper's settings if left out.
        out
            New folder of the campaign; ``runs/NAME-CASE-N`` if left out.
        engine
            As ``fly`` takes it.
        workers
            Processes; as many as there are processors if left out.
        dask
            Address of a scheduler that has the workers, or ``local`` for a cluster of this machine.
        explain
            Whether to search for weaknesses at the end.
        progress
            Called after each generation.
        tell
            Receives lines of progress, such as the engine.
        settings
            Values that replace those of the campaign file, such as ``generations=5, seed=2``.

        Returns
        -------
        Campaign
            The results, which its folder keeps.

        Raises
        ------
        UsageError
            If a setting is wrong; before anything is written.
        RecordError
            If the folder is in use, or cannot be written.
        """
        from mrsfi import evolving  # noqa: PLC0415 - brings numpy
        from mrsfi.campaign import Campaign  # noqa: PLC0415 - likewise

        if case is None:
            chosen = CampaignSettings.parse("[search]", "settings", **settings)
        else:
            chosen = CampaignSettings.load(campaign_file(self.folders, case), **settings)
        asked, many = _settings(engine), _workers(workers, dask)
        many.require_sense(asked)
        begun = evolving.begun(
            *(self.folders, self.code, chosen, str(case or "script"), asked),
            out=_path("out", out),
            tell=tell,
        )
        with begun as (campaign, flown_by):
            watched = nullcontext(progress)
            evolving.evolve(campaign, flown_by, many, watched, explains=explain, tell=tell)
        return Campaign(campaign.folder.path)

    def compare(  # noqa: PLR0913 - most have a default
        self,
        algorithms: "Sequence[str | Variant]",
        n_seeds: int,
        evaluations: int,
        *,
        sweep: str | None = None,
        case: str = "a",
        out: Path | str | None = None,
        engine: str | EngineSettings = AUTO,
        workers: int | None = None,
        dask: str | None = None,
        progress: "Callable[[RunResult, int, bool], None]" = lambda *_: None,
        tell: Tell = silent,
        on_reached: Tell = silent,
    ) -> "Comparison":
        """Compare search algorithms, or settings of one, with seeds 1 to ``n_seeds``.

        Parameters
        ----------
        algorithms
            Names as in a campaign file, only one with ``sweep``; or a ``Variant``: a name, and the
            values that it replaces in the campaign file.
        n_seeds, evaluations
            Runs of each setup, and evaluations of each run.
        sweep
            Numeric settings and their values, ``crossover=0.3:0.9:5`` (five, evenly spaced) or
            ``population=10,20,40``, separated by commas; all are combined, and each setup is
            compared with the paper's.
        case, engine, workers, dask
            As ``evolve`` takes them.
        out
            Folder of the comparison, whose finished runs are not repeated;
            ``runs/compare-NAME-CASE`` if left out.
        progress
            Receives each run, the number of runs so far, and whether it was made just now.
        tell
            Receives what does not compile.
        on_reached
            Receives the engine and the number of workers before the first run.

        Raises
        ------
        UsageError
            If a setting is wrong; before anything is written.
        RecordError
            If the folder is another comparison's.
        """
        from mrsfi.comparing import compared, default_folder, settings_of  # noqa: PLC0415
        from mrsfi_runtime.study.comparison import Sweep, variants_of  # noqa: PLC0415

        swept = None if sweep is None else Sweep.parse(sweep)
        variants = variants_of(algorithms, swept)
        n_seeds, who = require_whole("n_seeds", n_seeds), _workers(workers, dask)
        kind = "compare" if swept is None else "sweep"
        path, asked = _path("out", out) or default_folder(self.name, case, kind), _settings(engine)
        who.require_sense(asked)
        file = campaign_file(self.folders, case)
        settings = [*settings_of(file, self.code, variants, evaluations)]
        runs = [
            (name, replace(one, seed=1 + seed)) for seed in range(n_seeds) for name, one in settings
        ]
        seed = runs[0][1].mission_seed
        flown_by = tried(asked, self.code, seed, tell)
        evaluating = partial(
            evaluator,
            seed=seed,
            engine=flown_by,
            workers=who,
            tell=tell,
            on_reached=lambda they: on_reached(f"{flown_by.words}, {they}"),
        )
        return compared(path, self.folders, runs, swept, case, asked, evaluating, progress)

    def check(
        self, engine: str | EngineSettings = AUTO, n_seeds: int | None = None
    ) -> "tuple[Checked, ...]":
        """Fly every kept weakness against today's models and code.

        Parameters
        ----------
        engine
            As ``fly`` takes it.
        n_seeds
            Number of mission seeds: first those of the limits, then others.

        Raises
        ------
        UsageError
            If nothing is kept.
        """
        from mrsfi.regressions import check_all  # noqa: PLC0415 - brings numpy

        n_seeds = None if n_seeds is None else require_whole("n_seeds", n_seeds)
        return tuple(check_all(self.folders, _settings(engine), n_seeds=n_seeds))


def _settings(engine: str | EngineSettings) -> EngineSettings:
    return engine if isinstance(engine, EngineSettings) else EngineSettings(engine)


def _workers(workers: int | None, dask: str | None = None) -> Workers:
    return Workers(None if workers is None else require_whole("workers", workers), dask)


def _path(name: str, given: Path | str | None) -> Path | None:
    if given is not None and not isinstance(given, Path | str):
        raise UsageError(f"{name}: found {given!r}; expected the path of a folder")
    return None if given is None else Path(given)


def _with_settings(function: Callable[..., object]) -> Signature:
    """Return a signature that names every setting of a campaign, for completion in a notebook."""
    found = signature(function)
    named = [
        Parameter(each.name, Parameter.KEYWORD_ONLY, default=None)
        for each in fields(CampaignSettings)
        if each.init and each.name not in {"source", "options"}
    ]
    usual = [each for each in found.parameters.values() if each.kind is not Parameter.VAR_KEYWORD]
    return found.replace(parameters=[*usual, *named])


setattr(Mission.evolve, "__signature__", _with_settings(Mission.evolve))  # noqa: B010 - mypy knows none
