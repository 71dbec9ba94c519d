"""What causes are in case A: the tables of docs/causes.md, searched, explained and printed.

Run ``python -m benchmarks.causes`` from the project's folder. A campaign that is there already, in
``runs/causes``, is not searched again.
"""

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from time import monotonic
from typing import Any

from benchmarks.measuring import mrsfi

RUNS = Path("runs/causes")
MISSION, CASE = "uuv_sampling", "a"
SEEDS = (1, 2, 3)
N_TOP = 10
FEW = 10  # of the 20 mission seeds


def campaign(seed: int) -> tuple[Path, float]:
    """Return a campaign, and how many seconds it took."""
    folder = RUNS / str(seed)
    if (folder / "summary.json").is_file():
        return folder, float("nan")
    began = monotonic()
    mrsfi("evolve", MISSION, "--case", CASE, "--seed", seed, "--out", folder)
    return folder, monotonic() - began


def ticks(faults: Sequence[Mapping[str, Any]]) -> int:
    """Return the fault-ticks of some faults."""
    return sum(last - first + 1 for first, last in filter(None, (f["window"] for f in faults)))


def cause_faults(found: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the faults of a cause set."""
    return [fault for fault in found["faults"] if fault["id"] in found["cause_set"]["faults"]]


def firm(found: Mapping[str, Any], is_meant: Callable[[int], bool]) -> int:
    """Return how many goals are truly violated under a cause set, and in so many weathers."""
    columns = zip(found["columns"], found["cause_set"]["counts"], found["firmness"], strict=True)
    return sum(
        column["kind"] == "true" and count > 0 and is_meant(firmness["n_violated"])
        for column, count, firmness in columns
    )


def rows_of(seed: int) -> dict[str, str]:
    """Return a column of the table, by the names of its rows."""
    folder, evolved = campaign(seed)
    began = monotonic()
    printed = json.loads(mrsfi("explain", folder, "--top", N_TOP, "--json"))
    seconds = monotonic() - began
    summary = json.loads((folder / "summary.json").read_text())
    each = printed["explanations"]
    sizes = [len(found["cause_set"]["faults"]) for found in each]
    flown: Counter[str] = Counter()
    for found in each:
        flown.update(found["n_flown"])
    kept = {
        "fault-ticks: specification": lambda found: found["faults"],
        "– cause set": cause_faults,
        "– simplest form": lambda found: found["simplest"]["faults"],
    }
    rows = {
        "faults of the cause set, of 20": f"{median(sizes):g} ({min(sizes)} to {max(sizes)})",
        **{
            name: f"{median(ticks(faults(found)) for found in each):,.0f}"
            for name, faults in kept.items()
        },
        "goals truly violated under a cause set, of all ten": str(
            sum(firm(found, lambda _: True) for found in each)
        ),
        "– of which in all of 20 mission seeds": str(
            sum(firm(found, lambda n: n == 20) for found in each)
        ),
        f"– in fewer than {FEW}": str(sum(firm(found, lambda n: n < FEW) for found in each)),
        "flights of the search": f"{summary['n_evaluations']:,}",
        "flights of `evolve` after the search": f"{summary['weaknesses']['n_flown']:,}",
        **{f"flights of `explain`: {part}": f"{n:,}" for part, n in flown.items()},
        "seconds of `evolve`, compiled before": f"{evolved:.0f}",
        "seconds of `explain --top 10`": f"{seconds:.0f}",
    }
    Path(folder / "explained.json").write_text(json.dumps(printed), encoding="utf-8")
    return rows


def types() -> list[tuple[str, int, int]]:
    """Return how often each type of fault is in the top tens, and in their cause sets."""
    popular: Counter[str] = Counter()
    guilty: Counter[str] = Counter()
    for seed in SEEDS:
        printed = json.loads((RUNS / str(seed) / "explained.json").read_text())
        for found in printed["explanations"]:
            popular.update(fault["type"] for fault in found["faults"])
            guilty.update(fault["type"] for fault in cause_faults(found))
    return [(name, n, guilty[name]) for name, n in popular.most_common()]


def main() -> None:
    """Search what is missing, explain, and print both tables."""
    mrsfi("evolve", MISSION, "--generations", 1, "--out", RUNS / "compiled")  # so that it is cached
    columns = [rows_of(seed) for seed in SEEDS]
    print(f"| | {' | '.join(f'seed {seed}' for seed in SEEDS)} |")
    print("|---|" + "---:|" * len(SEEDS))
    for name in columns[0]:
        print(f"| {name} | {' | '.join(column.get(name, '–') for column in columns)} |")
    print("\n| Type | in the top tens | in their cause sets |\n|---|---:|---:|")
    for row in types():
        print(f"| {' | '.join(map(str, row))} |")


if __name__ == "__main__":
    main()
