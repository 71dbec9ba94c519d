"""What weaknesses of mrsfi's own world are worth in slower ones: those of ``examples/worlds``.

Run ``python -m benchmarks.transfer [WORLD ...]`` from the project's folder, with what
``pip install -e '.[examples]'`` installs; it takes an hour on two cores.

In mrsfi's own world ``cover`` looks for weaknesses, and shrinks each to its mildest form. In each
other world both forms are flown, and shrunk there again. Then that world is searched as ``cover``
does, by some seeds, once from nothing and once with the forms from the own world flown first: what
is told after as many flights is counted, a weakness being a goal, a measure and a set of faults.
Everything is of one mission seed.
"""

import argparse
import json
import shlex
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import chain, compress, islice
from pathlib import Path
from random import Random
from statistics import median
from time import monotonic
from typing import Any, NamedTuple

from mrsfi_runtime.analysis.tables import Table, to_markdown
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import Probing
from mrsfi_runtime.causes.mildest import Deviation, goal_weaknesses, mildest
from mrsfi_runtime.causes.weakness import Known, Weakness, form, parts, yardstick_of
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.search.space import SearchSpace

MISSION = load_code(Path("generated") / "uuv_sampling")
MODEL = Path("models") / "uuv_sampling"
SPACE = SearchSpace.of(MISSION.mission, MISSION.pool)
WORLDS = {"mujoco": "MuJoCo", "irsim": "ir-sim", "fossen": "Fossen"}
SEED = 1  # of the mission
N_FAULTS = 20  # of a specification, as the case studies have
N_OWN = 909  # flights of the search in the own world
SEARCHES = (1, 2, 3)
AFTER = (30, 60, 120)


class Search(NamedTuple):
    """What a search knows at its end, and the weaknesses that it told after each flight."""

    known: Known
    told: list[frozenset[str]]


def search(engine: Engine, n: int, seed: int, given: Sequence[Weakness] = ()) -> Search:
    """Search as ``cover`` does, with so many flights; given weaknesses first, with their parts."""
    known = Known(SPACE)
    probing = Probing(SPACE, known, N_FAULTS, Random(seed))
    yardstick = yardstick_of(MISSION.mission, engine.evaluate(()), SEED)
    told: list[frozenset[str]] = []
    turns = chain([forms(given)], iter(probing.turn, []))
    for flown in islice(chain.from_iterable(turns), n):
        known.learn(flown, yardstick.broken(engine.evaluate(flown)))
        for each in given:
            if each.witness == flown and holds(known, each):
                known.add(each.column, frozenset(each.faults))
        told.append(names(known))
    return Search(known, told)


def forms(given: Sequence[Weakness]) -> list[Specification]:
    """Return what tells whether weaknesses hold: of each its parts, then its form."""
    wanted = ((*parts(each.witness), each.witness) for each in given)
    return [*dict.fromkeys(chain.from_iterable(wanted))]


def holds(known: Known, weakness: Weakness) -> bool:
    """Return whether a form that was flown breaks the goal, and none of its parts."""
    broken = known.flown[form(weakness.witness)]
    alone = (known.flown[form(part)] for part in parts(weakness.witness))
    return weakness.column in broken.difference(*alone)


def names(known: Known) -> frozenset[str]:
    """Return the weaknesses that are known."""
    return frozenset(name(c, each) for c, some in known.sets.items() for each in some)


def name(column: Column, faults: Iterable[str]) -> str:
    """Return a goal, a measure and a set of faults as a word."""
    return " ".join((*column, *sorted(faults)))


class Own(NamedTuple):
    """Weaknesses of the own world, one for each goal and set of faults, as shown and mildest."""

    shown: tuple[Weakness, ...]
    mildest: tuple[Weakness, ...]


def own() -> Own:
    """Return what ``cover`` finds in the own world."""
    engine = open_engine(EngineSettings("compiled"), MISSION, SEED)
    known = search(engine, N_OWN, SEED).known
    shown = tuple(each.shown for each in goal_weaknesses(known.weaknesses()))
    least = mildest(SPACE, known, shown, engine.evaluate_many, engine.record, (SEED,))
    return Own(shown, tuple(each.weakness for each in least))


def opened(world: str) -> Engine:
    """Return an engine that flies in a world of the examples, which it starts."""
    place = Path("examples") / "worlds" / world / "world.py"
    command = shlex.join([sys.executable, str(place), "--mission", str(MODEL), "--url", "{url}"])
    settings = EngineSettings("rosbridge", side="ci", world=command, is_bundled=True)
    return open_engine(settings, MISSION, SEED)


def transferred(engine: Engine) -> dict[str, Any]:
    """Return how many weaknesses of the own world hold in another, as they are and shrunk there."""
    found = own()
    given = [*found.shown, *found.mildest]
    begin = monotonic()
    known = search(engine, len(forms(given)), SEED, given).known
    seconds = (monotonic() - begin) / len(known.flown)
    pairs = [*zip(found.shown, found.mildest, strict=True)]
    breaks = [holds(known, shown) or holds(known, least) for shown, least in pairs]
    given = [*compress(found.shown, breaks)]
    there = mildest(SPACE, known, given, engine.evaluate_many, engine.record, (SEED,))
    deviation = Deviation(SPACE, engine.record(()))
    n_flights = [each.n_flights for each in there]
    shrunk = [each.weakness for each in there if each.weakness.n_held]
    return {
        "all": len(pairs),
        "shown": sum(holds(known, each) for each in found.shown),
        "mildest": sum(holds(known, each) for each in found.mildest),
        "shrunk": len(shrunk),
        "sizes": [
            median(deviation.size(each.witness) for each in some)
            for some in (compress(found.mildest, breaks), shrunk)
        ],
        "flights": sum(n_flights) / len(n_flights),
        "seconds": seconds,
        "lost": [
            name(s.column, s.faults)
            for (s, _), is_there in zip(pairs, breaks, strict=True)
            if not is_there
        ],
    }


def searched(engine: Engine, seed: int) -> list[list[list[str]]]:
    """Return what two searches told after some flights: from nothing, and from the own world's."""
    both = [search(engine, AFTER[-1], seed, given).told for given in ((), own().shown)]
    return [[sorted(told[min(n, len(told)) - 1]) for n in AFTER] for told in both]


def job(world: str, part: str) -> Any:
    """Do one part of the work in a process of its own."""
    words = [sys.executable, "-m", "benchmarks.transfer", world, "--part", part]
    return json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout)


def transfers(found: Mapping[str, Any]) -> Table:
    """Return what became of the weaknesses of the own world in others."""
    rows = [
        (
            WORLDS[world],
            *(f"{told[what]} of {told['all']}" for what in ("shown", "mildest", "shrunk")),
            " → ".join(f"{size:.2f}" for size in told["sizes"]),
            told["flights"],
            told["seconds"],
        )
        for world, told in found.items()
    ]
    columns = "world", "as shown", "mildest", "shrunk there", "size", "flights each", "s a flight"
    return Table("", columns, rows)


def searches(found: Mapping[str, Sequence[Any]]) -> Table:
    """Return what searches of each world told, as shares of all that any of them did."""
    rows = []
    for world, runs in found.items():
        every = {each for run in runs for told in run for each in told[-1]}
        for place, begin in enumerate(("from nothing", "from the own world's")):
            told = ([len(run[place][k]) / len(every) for run in runs] for k in range(len(AFTER)))
            shares = (f"{min(each):.2f} to {max(each):.2f}" for each in told)
            rows.append((WORLDS[world], len(every), begin, *shares))
    return Table("", ("world", "any told", "begun", *map(str, AFTER)), rows)


def main() -> None:
    """Print both tables, and what is lost."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("worlds", nargs="*", metavar="WORLD", help="all if none is named")
    parser.add_argument("--part", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    worlds = arguments.worlds or [*WORLDS]
    if arguments.part is not None:
        with opened(*worlds) as engine:
            is_seed = arguments.part.isdecimal()
            part = searched(engine, int(arguments.part)) if is_seed else transferred(engine)
        return print(json.dumps(part))
    wanted = [(world, part) for world in worlds for part in ("transfer", *map(str, SEARCHES))]
    with ThreadPoolExecutor(2) as jobs:
        found = dict(zip(wanted, jobs.map(job, *zip(*wanted, strict=True)), strict=True))
    moved = {world: found[world, "transfer"] for world in worlds}
    print(to_markdown(transfers(moved)))
    for world, told in moved.items():
        print(f"{WORLDS[world]} loses", "; ".join(told["lost"]) or "nothing")
    runs = {world: [found[world, str(seed)] for seed in SEARCHES] for world in worlds}
    return print(to_markdown(searches(runs)))


if __name__ == "__main__":
    main()
