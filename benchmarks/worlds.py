"""Campaigns in slower worlds, those of ``examples/worlds``, which mrsfi starts.

Run ``python -m benchmarks.worlds [WORLD ...]`` from the project's folder, with what
``pip install -e '.[examples]'`` installs; it takes an hour on two cores.

In each world, ``mrsfi evolve`` flies 60 evaluations with one worker and with two; then a third
campaign, of which ten times a world, a worker or mrsfi itself is killed, and which is continued.
All three must have one digest, and no process may be left. Then ``mrsfi confirm`` flies the 20
gravest weaknesses of mrsfi's own world there, with two workers.
"""

import argparse
import json
import os
import shlex
import signal
import subprocess
import sys
from contextlib import suppress
from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import Any

from mrsfi_runtime.analysis.tables import Table, to_markdown
from tests.support.processes import descendants, is_running

WORLDS = {"mujoco": "MuJoCo", "irsim": "ir-sim", "fossen": "Fossen"}
MISSION = "uuv_sampling"
SEARCH = ("--population", "10", "--evaluations", "60", "--no-explain")
OWN = ("--algorithm", "cover", "--evaluations", "300")
N_KILLS, N_WEAKNESSES = 10, 20
MRSFI = (str(Path(sys.executable).with_name("mrsfi")),)


def command_of(world: str) -> str:
    """Return the command that starts a world of the examples."""
    place = Path("examples") / "worlds" / world / "world.py"
    words = "python", str(place), "--mission", f"models/{MISSION}", "--url", "{url}"
    return shlex.join(words)


def run(*words: str | Path) -> str:
    """Run ``mrsfi``, and return what it prints."""
    line = [*MRSFI, *map(str, words)]
    return subprocess.run(line, check=True, stdout=subprocess.PIPE, text=True).stdout


def digest(out: Path) -> str:
    """Return the digest of a campaign."""
    return str(json.loads((out / "summary.json").read_text(encoding="utf-8"))["digest"])


def searched(out: Path, *options: str) -> tuple[str, float]:
    """Return the digest of a campaign in a world, and the seconds that it took."""
    begin = monotonic()
    run("evolve", MISSION, *SEARCH, *options, "--out", out)
    return digest(out), monotonic() - begin


def killed(out: Path, world: str, seconds: float, *options: str) -> tuple[str, int, int]:
    """Return the digest of a campaign some of whose processes are killed, and how many were.

    ``seconds`` is how long it takes undisturbed. The last number is that of processes that were
    left five seconds after mrsfi had ended.
    """
    n_left, n_killed = 0, 0
    words_of = {"world": f"worlds/{world}/world.py", "worker": "spawn_main"}
    kinds = cycle((*words_of, "mrsfi"))
    while True:
        begun = (out / "campaign.sqlite").exists()
        words = ("evolve", "--resume", str(out)) if begun else ("evolve", MISSION, *SEARCH)
        more = ("--workers", "2") if begun else (*options, "--workers", "2", "--out", str(out))
        started = set[int]()
        with subprocess.Popen([*MRSFI, *words, *more], stdout=subprocess.DEVNULL) as running:
            while n_killed < N_KILLS and running.poll() is None:
                sleep(max(3.0, seconds / N_KILLS))
                kind, ours = next(kinds), descendants(running.pid)
                started |= {*ours}
                found = [each for each in ours if words_of.get(kind, "\0") in command_line(each)]
                pid = running.pid if kind == "mrsfi" else next(iter(found), None)
                if pid is not None and running.poll() is None:
                    os.kill(pid, signal.SIGKILL)
                    n_killed += 1
                    if kind != "world":
                        break
            code = running.wait()
        sleep(5.0)
        n_left += sum(map(is_running, started))
        if code == 0:
            return digest(out), n_killed, n_left


def command_line(pid: int) -> str:
    """Return the command line of a process; empty if it has ended."""
    with suppress(FileNotFoundError, ProcessLookupError):
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode()
    return ""


def gravest(own: Path) -> list[int]:
    """Return the numbers of the weaknesses of a campaign that are flown elsewhere."""
    order = ("missed", "true", "believed")
    found = json.loads(run("weaknesses", own, "--json"))
    found.sort(key=lambda each: order.index(each["measure"]))
    return [*dict.fromkeys(each["number"] for each in found)][:N_WEAKNESSES]


def main() -> None:
    """Print a table of the campaigns, and what ``mrsfi confirm`` prints in each world."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("worlds", nargs="*", metavar="WORLD", help="all if none is named")
    worlds = parser.parse_args().worlds or [*WORLDS]
    campaigns = list[tuple[Any, ...]]()
    with TemporaryDirectory() as folder:
        own = Path(folder) / "own"
        run("evolve", MISSION, *OWN, "--out", own)
        some = [word for number in gravest(own) for word in ("--weakness", str(number))]
        for world in worlds:
            options = ("--world", command_of(world), "--bundle")
            place = Path(folder) / world
            one, alone = searched(place / "one", *options, "--workers", "1")
            two, together = searched(place / "two", *options, "--workers", "2")
            last, *counts = killed(place / "killed", world, together, *options)
            is_same = "same" if one == two == last else "DIFFERENT"
            campaigns.append((WORLDS[world], alone, together, together / alone, is_same, *counts))
            begin = monotonic()
            print(run("confirm", own, *some, *options, "--workers", "2"))
            print(f"{WORLDS[world]}: {monotonic() - begin:.0f} s", flush=True)
    columns = "world", "1 worker, s", "2 workers, s", "ratio", "digest", "killed", "left running"
    print(to_markdown(Table("", columns, campaigns)))


if __name__ == "__main__":
    main()
