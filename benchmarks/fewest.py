"""How much harm with how few faults: the table of docs/search.md, searched and printed.

Run ``python -m benchmarks.fewest`` from the project's folder. A campaign that is there already, in
``runs/fewest``, is not searched again.
"""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mrsfi_runtime.record.settings import VIOLATIONS

RUNS = Path("runs/fewest")
CASES = {
    "case A": ("uuv_sampling", "a"),
    "case B": ("uuv_sampling", "b"),
    "`tight_energy` a": ("tight_energy", "a"),
    "`tight_energy` b": ("tight_energy", "b"),
    "`tight_margins` a": ("tight_margins", "a"),
}
SEEDS = (1, 2, 3)
N_EVALUATIONS = 2000
MOST_FAULTS = 10
SHOWN = (1, 2, 3, 4, 5, 6, 10)


def found(mission: str, case: str, violations: str, seed: int) -> list[dict[str, Any]]:
    """Return the front of harm that one search found."""
    folder = RUNS / f"{mission}-{case}-{violations}-{seed}"
    if not (folder / "summary.json").is_file():
        options = {
            "case": case,
            "violations": violations,
            "seed": seed,
            "algorithm": "guided",
            "minimise": "faults",
            "faults": MOST_FAULTS,
            "evaluations": N_EVALUATIONS,
            "workers": 1,
            "out": folder,
        }
        words = [word for name, value in options.items() for word in (f"--{name}", str(value))]
        command = [
            sys.executable,
            "-m",
            "mrsfi_runtime.cli.main",
            "evolve",
            mission,
            "--no-explain",
        ]
        command += words
        subprocess.run(command, check=True, capture_output=True)
    harm: list[dict[str, Any]] = json.loads((folder / "summary.json").read_text())["harm"]
    return harm


def most(harm: Sequence[dict[str, Any]], n_faults: int) -> str:
    """Return the most goals that so few faults violated, and the most violations."""
    few = [each for each in harm if each["cost"] <= n_faults]
    n_goals = max((each["n_violated"] for each in few), default=0)
    return f"{n_goals}: {max((each['violations'] for each in few), default=0):,}"


def main() -> None:
    """Search what is missing, and print the table."""
    RUNS.mkdir(parents=True, exist_ok=True)
    print(f"| | | {' | '.join(map(str, SHOWN))} |", "|" + "---|" * (2 + len(SHOWN)), sep="\n")
    for label, (mission, case) in CASES.items():
        for kind in VIOLATIONS:
            harm = [each for seed in SEEDS for each in found(mission, case, kind, seed)]
            cells = " | ".join(most(harm, n_faults) for n_faults in SHOWN)
            print(f"| {label} | {kind} | {cells} |", flush=True)


if __name__ == "__main__":
    main()
