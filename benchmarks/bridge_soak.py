"""Whether ``mrsfi bridge`` stays as it is under mixed traffic: memory, delay, every message.

Run ``python -m benchmarks.bridge_soak --minutes 10`` from the project's root after ``make
install``. Half of the clients are plain websockets with compressions none, png, cbor and
cbor-raw, throttled and in fragments; a quarter each are roslibpy clients of both transports.
They publish on ten topics from 1 to 50 messages a second and 10 to 300,000 letters, subscribe
to four each, leave one of them and join it again, and provide and call services.

Ends with 1 if a message within a topic was lost or out of order, a call was not answered
rightly, or memory or delay of the last fifth exceed those of the first.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

KINDS = ("raw", "asyncio", "raw", "twisted")
"""Kinds of clients, by turns."""
JOINING = 10.0
"""Seconds for all clients to join before services are called and anything is compared."""
MEBI = 1 << 20
GROWTH = 1.1
GROWTH_BYTES = 4 * MEBI
"""Memory may grow by a tenth or so many bytes: allocators are not exact."""
DELAY_GROWTH = 2.0
DELAY_GROWTH_S = 0.02
"""The median delay may double and be so much longer, because others use this machine too."""


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


def resident_bytes(pid: int, key: str = "VmRSS:") -> int:
    """Return the memory of a process, or another number of bytes of its status."""
    for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith(key):
            return int(line.split()[1]) * 1024
    raise ValueError(key)


def reports(
    url: str, n_clients: int, begin: float, end: float, look: Callable[[], None]
) -> list[dict[str, Any]]:
    """Run all clients to the end and return what they saw."""
    indexes: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for index in range(n_clients):
        indexes[KINDS[index % len(KINDS)]].append(str(index))
    processes = [
        subprocess.Popen(
            [
                sys.executable,
                "-m",
                "benchmarks.soak_clients",
                kind,
                url,
                str(begin),
                str(end),
                *own,
            ],
            stdout=subprocess.PIPE,
            encoding="utf-8",
        )
        for kind, own in indexes.items()
        if own
    ]
    while time.monotonic() < end:
        look()
        time.sleep(0.5)
    outputs = [process.communicate(timeout=60)[0] for process in processes]
    if any(process.returncode for process in processes):
        raise SystemExit("a process of clients failed")
    return [json.loads(output.splitlines()[-1]) for output in outputs]


def fifths(
    samples: list[tuple[float, float]], begin: float, end: float
) -> tuple[list[float], list[float]]:
    """Return the values of the first and of the last fifth of the time."""
    length = (end - begin) / 5
    first = [value for moment, value in samples if begin <= moment < begin + length]
    last = [value for moment, value in samples if end - length <= moment < end]
    return first, last


def is_memory_steady(samples: list[tuple[float, float]], begin: float, end: float) -> bool:
    """Print the memory of both fifths; return whether it stayed."""
    first, last = (statistics.median(values) for values in fifths(samples, begin, end))
    is_steady = last <= max(first * GROWTH, first + GROWTH_BYTES)
    print(
        f"memory of the server  {first / MEBI:8.1f} MiB in the first fifth, "
        f"{last / MEBI:.1f} in the last: {_verdict(is_steady)}"
    )
    return is_steady


def is_delay_steady(samples: list[tuple[float, float]], begin: float, end: float) -> bool:
    """Print the delays of both fifths; return whether the median stayed."""
    first, last = fifths(samples, begin, end)
    medians = statistics.median(first), statistics.median(last)
    is_steady = medians[1] <= max(medians[0] * DELAY_GROWTH, medians[0] + DELAY_GROWTH_S)
    print(
        f"delay, median         {medians[0] * 1e3:8.2f} ms in the first fifth, "
        f"{medians[1] * 1e3:.2f} in the last: {_verdict(is_steady)}"
    )
    tails = [statistics.quantiles(values, n=100)[-1] * 1e3 for values in (first, last)]
    print(
        f"delay, 99 of 100      {tails[0]:8.2f} ms in the first fifth, {tails[1]:.2f} in the last"
    )
    return is_steady


def is_complete(found: list[dict[str, Any]], n_seconds: float) -> bool:
    """Print what became of the messages; return whether none was lost or out of order."""
    published = {
        int(topic): count for report in found for topic, count in report["published"].items()
    }
    receptions = [reception for report in found for reception in report["receptions"]]
    n_received = sum(reception["n_received"] for reception in receptions)
    n_lost = sum(reception["n_lost"] for reception in receptions)
    n_disordered = sum(reception["n_disordered"] for reception in receptions)
    n_lost += sum(
        published[reception["topic"]] - reception["last"] - 1
        for reception in receptions
        if not reception["is_throttled"] and not reception["is_changing"]
    )
    print(f"published             {sum(published.values()):8,} messages on {len(published)} topics")
    print(
        f"received              {n_received:8,} by {len(receptions)} subscriptions, "
        f"{n_received / n_seconds:,.0f} a second"
    )
    print(f"lost                  {n_lost:8,}")
    print(f"doubled or disordered {n_disordered:8,}")
    print(f"left and joined       {sum(report['n_rejoined'] for report in found):8,} times")
    return bool(n_lost == 0 and n_disordered == 0 and n_received > 0)


def are_calls_answered(found: list[dict[str, Any]]) -> bool:
    """Print what became of the calls; return whether all were answered rightly."""
    n_calls, n_answers, n_wrong = (
        sum(report[name] for report in found) for name in ("n_calls", "n_answers", "n_wrong")
    )
    print(f"service calls         {n_calls:8,}, {n_answers:,} answered, {n_wrong:,} wrongly")
    return bool(n_calls == n_answers and n_wrong == 0)


def _verdict(is_good: bool) -> str:
    return "steady" if is_good else "GREW"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--clients", type=int, default=20, help="an even number from 10")
    arguments = parser.parse_args()
    if arguments.clients < 10 or arguments.clients % 2:
        parser.error("--clients: expected an even number, at least 10")
    return arguments


def main() -> int:
    """Print the figures; return 1 if something was lost or grew."""
    arguments = _arguments()
    n_seconds = 60 * arguments.minutes
    memory: list[tuple[float, float]] = []
    with child("-m", "mrsfi_runtime.cli.main", "bridge", "--port", "0") as (url, pid):
        begin = time.monotonic() + JOINING
        end = begin + n_seconds

        def look() -> None:
            memory.append((time.monotonic(), resident_bytes(pid)))

        print(f"{arguments.clients} clients for {n_seconds:g} s on {url}", flush=True)
        found = reports(url, arguments.clients, begin, end, look)
        peak = resident_bytes(pid, "VmHWM:")
    delays = [
        (moment, delay)
        for report in found
        for reception in report["receptions"]
        for moment, delay in reception["delays"]
        if not reception["is_throttled"]
    ]
    verdicts = [
        is_complete(found, JOINING + n_seconds),
        are_calls_answered(found),
        is_memory_steady(memory, begin, end),
        is_delay_steady(delays, begin, end),
    ]
    print(f"memory at most        {peak / MEBI:8.1f} MiB")
    return 0 if all(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
