"""Fly the weaknesses of a campaign in another world, and record whether they break the same goals.

A campaign searches in the fast world of mrsfi. ``confirm`` flies its weaknesses in an external
simulation, the gravest first, with the campaign's own copies of models and code. What to fly next,
and what the flights show, follows from the record alone (``causes/confirmation.py``). So each
flight is recorded as it ends, in a table of its own; an interrupted command loses the flights under
way, and the same command continues.

All weaknesses fly their listed variants first, then milder ones. Several workers are threads, each
with an engine and so with a world of its own: a flight waits for the world most of the time.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from time import monotonic
from typing import Any, NamedTuple, TypeAlias

from mrsfi.campaign_folders import FlyableCampaign, open_to_fly
from mrsfi.engines import Given, Tell, chosen, now_and_then, silent
from mrsfi.explaining import harvested
from mrsfi_runtime.analysis.tables import Table
from mrsfi_runtime.causes.confirmation import BREAKS, N_LOOKS, SAME, Elsewhere
from mrsfi_runtime.causes.mildest import GoalWeakness, gravity
from mrsfi_runtime.causes.weakness import Yardstick
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import ReplayMismatch, UsageError, counted, time_left
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import wilson
from mrsfi_runtime.record.database import CampaignFolder, only_writer
from mrsfi_runtime.record.engine_settings import CI, INJECTOR, ROSBRIDGE, EngineSettings, Workers
from mrsfi_runtime.record.store import FlightElsewhere, RecordedFlight
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.transport.topics import without_token


class Budget(NamedTuple):
    """The most new flights, and the seconds after which none begins; ``None`` is no limit."""

    flights: int | None = None
    seconds: float | None = None

    def left(self, n_begun: int, seconds: float) -> tuple[float, float]:
        """Return how many flights and seconds are left."""
        flights = float("inf") if self.flights is None else self.flights - n_begun
        return flights, float("inf") if self.seconds is None else self.seconds - seconds


def confirm(
    run: Path,
    engine: Given,
    workers: Workers,
    choose: Callable[[Sequence[GoalWeakness]], Sequence[GoalWeakness]] = lambda found: found,
    budget: Budget | None = None,
    tell: Tell = silent,
    *,
    is_anew: bool = False,
) -> Elsewhere:
    """Fly the chosen weaknesses of a campaign in another world, within a budget.

    If it is anew, earlier flights there are forgotten. A world that repeats itself and differs from
    the one that was recorded under its name is a ``ReplayMismatch``.
    """
    with only_writer(CampaignFolder(run)), open_to_fly(run, tell) as campaign:
        store, flown_by = campaign.store, campaign.store.manifest.engine
        side = INJECTOR if flown_by.side == INJECTOR else CI
        settings = chosen({"name": ROSBRIDGE, "side": side, **engine})
        world = world_of(settings)
        if settings.side != side:
            raise UsageError(f"{run}: was flown with {flown_by.parts}; expected --side {side}")
        workers.require_sense(settings)
        found = harvested(campaign).goal_weaknesses
        some = sorted(choose(found), key=gravity(campaign.mission))
        if is_anew:
            store.forget_elsewhere(world)
        space = SearchSpace.of(campaign.mission, campaign.pool)
        flights = (each for each in store.flights_elsewhere() if each.world == world)
        study, n_workers = Elsewhere(world, space, some, flights), workers.count(settings)
        if next(study.wanted(()), None) is not None:
            tell(f"confirm    {counted(len(some), 'weaknesses')} in {world}")
            with _flying(campaign, study, settings, n_workers) as (begin, own):
                _require_same_world(run, study, own)
                for flight in _flown(study, begin, n_workers, budget or Budget(), tell):
                    store.append_elsewhere(flight)
                    study.learn(flight)
        return study


def world_of(settings: EngineSettings) -> str:
    """Return how another world is reached; flights in worlds with equal names are counted together.

    A world of mrsfi's own is a ``UsageError``.
    """
    if settings.has_own_world:
        raise UsageError(f"found {settings.parts}; expected another world: --side {CI} --url URL")
    prefix = f" under {settings.world_prefix}" if settings.world_prefix else ""
    return f"{settings.world or without_token(str(settings.url))}{prefix}"


Begin: TypeAlias = Callable[[Specification], "Future[FlightElsewhere]"]
"""Begins a flight in another world, in a thread."""


@contextmanager
def _flying(
    campaign: FlyableCampaign, study: Elsewhere, settings: EngineSettings, n_workers: int
) -> Iterator[tuple[Begin, Engine]]:
    """Yield a function that begins flights, and one of the engines that fly."""
    free, seed = SimpleQueue[Engine](), campaign.store.settings.mission_seed

    def fly(specification: Specification, yardstick: Yardstick | None) -> FlightElsewhere:
        engine, began, since = free.get(), monotonic(), dict[tuple[str, str], int]()

        def note(world: State, _: State, verdicts: Verdicts) -> None:
            for column in yardstick.over(verdicts) if yardstick else ():
                since.setdefault(column, world.mission.tick)

        try:
            found = engine.attempt(specification, observer=note)
        finally:
            free.put(engine)
        flown = RecordedFlight(seed, specification, found)
        return FlightElsewhere(study.world, flown, since, monotonic() - began)

    with ThreadPoolExecutor(n_workers) as pool, ExitStack() as opened:
        for _ in range(n_workers):
            engine = opened.enter_context(open_engine(settings, campaign.code, seed))
            free.put(engine)
        yield lambda each: pool.submit(fly, each, study.yardstick), engine


def _require_same_world(run: Path, study: Elsewhere, engine: Engine) -> None:
    """Refuse a world that repeats itself if its flight without faults differs from its record."""
    if study.repeats_itself and study.flights[()][0].flown.found != engine.attempt(()):
        raise ReplayMismatch(
            f"{run}: the flight without faults in {study.world} differs from its record; expected "
            "the same world as before; --anew forgets what was flown there"
        )


def _flown(
    study: Elsewhere, begin: Begin, n_workers: int, budget: Budget, tell: Tell
) -> Iterator[FlightElsewhere]:
    """Yield the flights that are wanted until none is, or the budget is spent."""
    running: dict[Future[FlightElsewhere], Specification] = {}
    n_begun, began, tell_of = 0, monotonic(), now_and_then(tell)
    while True:
        for each in study.wanted([*running.values()]):
            n_left, left = budget.left(n_begun, monotonic() - began)
            if len(running) == n_workers or min(n_left, left) <= 0:
                break
            running[begin(each)] = each
            n_begun += 1
        if not running:
            return
        ended = wait(running, return_when=FIRST_COMPLETED).done
        for done in sorted(ended, key=lambda each: each.exception() is not None):
            del running[done]
            yield done.result()
        n_done, seconds = n_begun - len(running), monotonic() - began
        tell_of(partial(_progress, study, n_done, seconds, budget))


def _progress(study: Elsewhere, n_done: int, seconds: float, budget: Budget) -> str:
    """Return how far a study is, and how long it may still take."""
    asks = [step for *_, step in study.results()]
    n_open = len([*filter(None, asks)])
    n_flights = sum(map(len, study.flights.values())) - N_LOOKS
    n_each = min(max(1.0, n_flights / max(1, len(asks) - n_open)), 3.0)  # of a weakness
    n_left, left = budget.left(n_done, seconds)
    rest = min(left, min(n_left, n_open * n_each) * seconds / n_done)
    share = study.transfer
    judged = f"{share.n_judged} of {counted(len(study.weaknesses), 'weaknesses')} judged"
    same = f"{share.n_same} break the same goal  {time_left(max(0.0, rest))}"
    return f"confirm    {counted(n_done, 'flights')}  {judged}, {same}"


def seconds_of(found: Elsewhere) -> list[float]:
    """Return how many seconds each recorded flight there took."""
    return [each.seconds for some in found.flights.values() for each in some]


def as_json(found: Elsewhere) -> dict[str, Any]:
    """Return the results as plain values."""
    seconds, share = seconds_of(found), found.transfer
    interval = wilson(share.n_same, share.n_judged) if share.n_judged else None
    rows = [
        {
            "number": weakness.number,
            "goal": weakness.goal,
            "measure": weakness.measure,
            "faults": [*weakness.faults],
            "there": each.as_json(),
        }
        for weakness, each, _ in found.results()
    ]
    return {
        "world": found.world,
        "repeats_itself": found.repeats_itself,
        "flights": len(seconds),
        "seconds": round(sum(seconds), 1),
        "share": {"same": share.n_same, "of": share.n_judged, "interval": interval},
        "weaknesses": rows,
    }


def table(found: Elsewhere) -> Table:
    """Return a row for each weakness: its goal in both worlds, and by how many ticks later there.

    If equal flights differ there, the last column says in how many the goal broke.
    """
    columns = ("#", "goal", "faults", "here", "there", "delay", "variant", "broke it in")
    n_shown = len(columns) - (found.repeats_itself is not False)
    rows = [
        (
            weakness.number,
            found.space.gate.mission.label_of(weakness.goal),
            " and ".join(weakness.faults),
            BREAKS[weakness.measure],
            each.words,
            None if each.delay is None else f"{each.delay:+d}",
            each.kind if each.verdict == SAME else None,
            each.share or None,
        )[:n_shown]
        for weakness, each, _ in found.results()
    ]
    title = f"Weaknesses in {found.world}, the gravest first; delay in ticks"
    words, texts = ("variant", "broke it in"), ("goal", "faults", "here", "there")
    return Table(title, columns[:n_shown], rows, words, texts, is_compact=True)
