"""How fast lock-step over a bus is: ticks a second, and seconds for one evaluation.

Run ``python -m benchmarks.lockstep`` from the project's root after ``make install``, or with
``--quick`` for a look. All rows are measured in one run, in turn, again and again.

First table: fifteen topics and a reply per tick, with unmodified roslibpy clients. *embedded*:
the simulation carries the server in its process, the CI is a client of it. *separate*: server,
simulation and CI are three processes. The floor is a plain websockets relay in the server's
place, which checks nothing. *alone*: the client on a bare socket, over which every tick goes in
one write that was encoded before: what it takes without any server. Second table: one evaluation of
the paper's mission with twenty timed faults, simulation and CI in two processes, with the
paper's topics and in bundles, beside the reference engine.

Ends with 1 if an aim is missed. The aims are those of two free processors; how much of them
other programs took is printed last.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.measuring import Others, drawn, run
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.generated_code import load_code

GENERATED = Path("generated") / "uuv_sampling"
CLIENTS = ("asyncio", "twisted")
PLACES = ("embedded", "separate")
FORMS = ("messages", "bundles")
AIMS = {
    ("asyncio", "embedded"): 1_500,
    ("asyncio", "separate"): 600,
    ("twisted", "embedded"): 600,
    ("twisted", "separate"): 600,
}
"""Ticks a second that the bridge is to reach."""
BRIDGE = ("mrsfi_runtime.cli.main", "bridge", "--port", "0")
SIDES = ("benchmarks.lockstep_sides",)
SERVERS = {
    ("alone", "prepared"): (*SIDES, "prepared"),
    ("embedded", "bridge"): (*SIDES, "embedded"),
    ("embedded", "relay"): (*SIDES, "embedded-relay"),
    ("separate", "bridge"): BRIDGE,
    ("separate", "relay"): (*SIDES, "relay"),
}
"""Module and arguments of what the CI is a client of, by place and server."""
AIM_SECONDS = 1.0
"""What an evaluation over the embedded server is to take at most."""


@dataclass(frozen=True)
class Case:
    """A figure of the first table; the place ``alone`` has no server."""

    client: str
    place: str
    server: str


@contextmanager
def child(*words: str) -> Iterator[tuple[str, int]]:
    """Run a server or a side that tells its URL; yield that and its process until the body ends."""
    with subprocess.Popen(
        [sys.executable, *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        encoding="utf-8",
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            line = process.stdout.readline().strip()
            if not line:
                message = f"{' '.join(words)}: did not start"
                raise SystemExit(message)
            url = json.loads(line)["url"] if line.startswith("{") else line.split()[-1]
            yield url, process.pid
        finally:
            process.terminate()
            process.communicate()


def rate(case: Case, seconds: float) -> float:
    """Return the ticks a second of one run."""
    with ExitStack() as stack:
        url, _ = stack.enter_context(child("-m", *SERVERS[case.place, case.server]))
        if case.place == "separate":
            stack.enter_context(child("-m", *SIDES, "simulation", url, case.client))
        found = run(*SIDES, "ci", url, case.client, str(seconds)).found()
    return float(found["rate"])


def measured_rates(n_rounds: int, seconds: float) -> dict[Case, list[float]]:
    """Return the rates of all cases, measured in turn."""
    cases = [
        Case(client, place, server) for client, place in AIMS for server in ("bridge", "relay")
    ]
    cases += [Case(client, "alone", "prepared") for client in CLIENTS]
    rates: dict[Case, list[float]] = {case: [] for case in cases}
    for _ in range(n_rounds):
        for case in cases:
            rates[case].append(rate(case, seconds))
    return rates


def evaluation_seconds(
    engine: str, url: str | None, n: int, *, is_bundled: bool
) -> tuple[list[float], list[str]]:
    """Return the seconds and digests of some evaluations; the first, unmeasured, warms up."""
    code = load_code(GENERATED)
    seconds, digests = [], []
    opened = (
        ReferenceEngine(code, 1)
        if engine == "reference"
        else RosbridgeEngine(
            code,
            1,
            url=url,
            client="asyncio" if engine == "asyncio" else "twisted",
            is_bundled=is_bundled,
        )
    )
    with opened:
        for specification in drawn(code, n + 1):
            start = time.perf_counter()
            digests.append(opened.evaluate(specification).digest)
            seconds.append(time.perf_counter() - start)
    return seconds[1:], digests


def quartiles(values: list[float]) -> tuple[float, float, float]:
    """Return the lower quartile, the median and the upper quartile."""
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, middle, high


def print_rates(rates: dict[Case, list[float]]) -> bool:
    """Print the first table; return whether all aims are reached."""
    print("Fifteen topics and a reply per tick, ticks/s: median [quartiles]")
    print("client   server                mrsfi bridge              plain relay  ratio    aim")
    is_reached = True
    for (client, place), aim in AIMS.items():
        texts, medians = [], []
        for server in ("bridge", "relay"):
            low, middle, high = quartiles(rates[Case(client, place, server)])
            medians.append(middle)
            texts.append(f"{middle:,.0f} [{low:,.0f}, {high:,.0f}]")
        verdict = "reached" if medians[0] > aim else "MISSED"
        is_reached &= medians[0] > aim
        print(
            f"{client:8} {place:9} {texts[0]:>24} {texts[1]:>24} "
            f"{medians[0] / medians[1]:6.2f} {aim:6,} {verdict}"
        )
    for client in CLIENTS:
        low, middle, high = quartiles(rates[Case(client, "alone", "prepared")])
        print(f"{client:8} alone     {middle:,.0f} [{low:,.0f}, {high:,.0f}], without a server")
    return is_reached


def print_evaluations(seconds: dict[str, list[float]], n_equal: int) -> bool:
    """Print the second table; return whether the aim is reached."""
    print()
    print("One evaluation of uuv_sampling, 1,000 ticks, seconds: median [quartiles]")
    reference = statistics.median(seconds["reference"])
    for name, values in seconds.items():
        low, middle, high = quartiles(values)
        print(
            f"{name:28} {middle:7.3f} [{low:.3f}, {high:.3f}]   {1_000 / middle:8,.0f} ticks/s   "
            f"{middle / reference:5.1f} times the reference"
        )
    is_reached = True
    for form in FORMS:
        name = f"asyncio, embedded, {form}"
        is_below = statistics.median(seconds[name]) < AIM_SECONDS
        is_reached &= is_below
        print(f"aim: {name} below {AIM_SECONDS:g} s: {'reached' if is_below else 'MISSED'}")
    print(f"{n_equal} evaluations over the bus gave the reference engine's digest, all that were")
    return is_reached


def measured_evaluations(n_rounds: int, n: int) -> tuple[dict[str, list[float]], int]:
    """Return the seconds by engine, in turn, and how many digests agreed; all have to."""
    ways = product(CLIENTS, PLACES, FORMS)
    names = ("reference", *(", ".join(way) for way in ways))
    seconds: dict[str, list[float]] = {name: [] for name in names}
    n_equal = 0
    for _ in range(n_rounds):
        expected: list[str] = []
        for name in names:
            found = _in_child(*name.split(", "), n=n)
            seconds[name] += found["seconds"]
            expected = expected or found["digests"]
            if found["digests"] != expected:
                message = f"{name}: the results are not those of the reference engine"
                raise SystemExit(message)
            n_equal += len(expected) if name != "reference" else 0
    return seconds, n_equal


def _in_child(engine: str, place: str = "", form: str = "", *, n: int) -> dict[str, Any]:
    """Evaluate in a process of its own: one has one kind of roslibpy client."""
    words = ["benchmarks.lockstep", "--evaluate", engine, "--count", str(n)]
    with ExitStack() as stack:
        if form == "bundles":
            words.append("--bundle")
        if place == "separate":
            words += ["--url", stack.enter_context(child("-m", *BRIDGE))[0]]
        found: dict[str, Any] = run(*words).found()
    return found


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="two short rounds")
    parser.add_argument("--only", choices=("rates", "evaluations"), help="one of the two tables")
    parser.add_argument("--evaluate", help=argparse.SUPPRESS)
    parser.add_argument("--url", help=argparse.SUPPRESS)
    parser.add_argument("--bundle", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--count", type=int, default=5, help=argparse.SUPPRESS)
    return parser.parse_args()


def main() -> int:
    """Print both tables; return 1 if an aim is missed."""
    arguments = _arguments()
    if arguments.evaluate:
        seconds, digests = evaluation_seconds(
            arguments.evaluate, arguments.url, arguments.count, is_bundled=arguments.bundle
        )
        print(json.dumps({"seconds": seconds, "digests": digests}))
        return 0
    n_rounds, length = (2, 0.7) if arguments.quick else (5, 2.0)
    others = Others()
    verdicts = []
    if arguments.only != "evaluations":
        verdicts.append(print_rates(measured_rates(n_rounds, length)))
    if arguments.only != "rates":
        n = 2 if arguments.quick else 4
        verdicts.append(print_evaluations(*measured_evaluations(n_rounds, n)))
    print(f"other programs kept {others.processors():.1f} of {os.cpu_count()} processors busy")
    return 0 if all(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
