"""Writes the compiled flight of one mission: the lock-step with its goal functions spelt out.

The flight is the loop of ``hosting.lockstep`` and ``hosting.ci_host`` without a bus. It goes to
a file because numba caches only what it finds in one. Numba does not notice when a function
that the file calls has changed, so the file's folder is named after a hash of all sources
that take part, and of the shapes that they are compiled for.
"""

import hashlib
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from types import ModuleType
from typing import get_args, get_type_hints

from mrsfi_runtime import kernel
from mrsfi_runtime.engine.compiled.layout import NEVER
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.mission import MissionCode, load_module
from mrsfi_runtime.record.trace import CHANGING

N_KEPT = 64
"""Compiled missions that the cache keeps; one takes about 2 MB."""

_TEXT = '''"""Compiled flight of a mission."""

import {collective} as ci
from mrsfi_runtime.kernel import delivery, effects, motion
from mrsfi_runtime.kernel.goal_tasks import progress
from mrsfi_runtime.kernel import tick as ticks
from numba import njit


@njit(cache=True, nogil=True, boundscheck=True)
def fly_many(first, last, fresh, room, states, plans, batch, tallies, ends, results, trace, at):
    world = states[0]
    belief = states[1]
    inbox = states[2]
    plan = plans[0]
    for k in range(first, last):
        at[0] = k
        for side in range(len(fresh)):
            for word in range(len(fresh[side])):
                room[side, word] = fresh[side, word]
        result = results[k]
        board(plan.messages, batch, ends[k, 0], ends[k, 1])
        board(plan.reports, batch, ends[k, 1], ends[k, 2])
        board(plan.commands, batch, ends[k, 2], ends[k, 3])
        for n in range(ends[k, 4], ends[k, 5]):
            plan.tallies[n - ends[k, 4]] = tallies[n]
        fly(world, belief, inbox, plan, result, trace, at)
        for n in range(ends[k, 4], ends[k, 5]):
            tallies[n] = plan.tallies[n - ends[k, 4]]
        for goal in range({n_goals}):
            result.samples[goal] = world.goals[goal].count
        pack(world, result.world)
        pack(belief, result.belief)


@njit(boundscheck=True, no_cfunc_wrapper=True)
def board(room, injections, first, last):
    for n in range(first, last):
        room[n - first] = injections[n]
    room[last - first].start = {never}


@njit(boundscheck=True, no_cfunc_wrapper=True)
def fly(world, belief, inbox, plan, result, trace, at):
    effects.issue(belief, world, plan, 0)
    for tick in range(world.mission.duration):
        at[1] = tick
        world.mission.tick = tick
        motion.advance(world)
        delivery.send(world, inbox)
        progress.progress(world)
{true_checks}
        ticks.perceive(belief, inbox, plan, tick)
{believed_checks}
{reactions}
        effects.issue(belief, world, plan, tick + 1)
        for goal in range({n_goals}):
            judge(result, goal)
        if tick < len(trace):
            pack(world, trace[tick].world)
            pack(belief, trace[tick].belief)
            for goal in range({n_goals}):
                trace[tick].is_true[goal] = result.is_true[goal]
                trace[tick].is_believed[goal] = result.is_believed[goal]


@njit(boundscheck=True, no_cfunc_wrapper=True)
def judge(result, goal):
    true = result.is_true[goal]
    believed = result.is_believed[goal]
    if true or believed:
        result.true[goal] += true
        result.believed[goal] += believed
        result.phantom[goal] += believed and not true
        result.masked[goal] += true and not believed


@njit(boundscheck=True, no_cfunc_wrapper=True)
def pack(state, values):
    n = 0
{packing}
'''


def driver_text(code: MissionCode, collective: str) -> str:
    """Return the source of a mission's compiled flight.

    Parameters
    ----------
    code
        Generated code of the mission.
    collective
        Name under which its collective intelligence can be imported.
    """
    return _TEXT.format(
        collective=collective,
        never=NEVER,
        n_goals=len(code.checks),
        true_checks=_checks(code, "world", "is_true"),
        believed_checks=_checks(code, "belief", "is_believed"),
        reactions="\n".join(f"        ci.{react.__name__}(belief)" for react in code.reactions),
        packing="\n".join(_packing()),
    )


def _checks(code: MissionCode, state: str, target: str) -> str:
    return "\n".join(
        f"        result.{target}[{goal}] = 1 if ci.{check.__name__}({state}) else 0"
        for goal, check in enumerate(code.checks)
    )


def _packing() -> list[str]:
    """Return lines that write what ``state_bytes`` takes, in its order."""
    hints = get_type_hints(State)
    lines = []
    for name in CHANGING:
        (record,) = get_args(hints[name])
        names = [field.name for field in fields(record)]
        lines += [f"    for i in range(len(state.{name})):", f"        record = state.{name}[i]"]
        for k, field in enumerate(names):
            lines.append(f"        values[n + {k}] = record.{field} + 0.0")
        lines.append(f"        n += {len(names)}")
    return lines


def cache_folder() -> Path:
    """Return where compiled code is kept: ``MRSFI_CACHE``, else the user's cache folder."""
    own = os.environ.get("MRSFI_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "mrsfi"


def source_hash(texts: Sequence[str]) -> str:
    """Return a key of the kernel's sources and of further texts."""
    sha = hashlib.sha256(sys.version.encode())
    folder = Path(str(kernel.__file__)).parent
    for path in sorted(folder.rglob("*.py")):
        sha.update(path.read_bytes())
    for text in texts:
        sha.update(b"\0")
        sha.update(text.encode())
    return sha.hexdigest()[:24]


def _make_room(cache: Path) -> None:
    """Remove the oldest compiled missions; who uses one has loaded it."""
    known = sorted(cache.glob("*/flight.py"), key=lambda path: path.stat().st_mtime)
    for path in known[: len(known) - N_KEPT + 1]:
        shutil.rmtree(path.parent, ignore_errors=True)


def load_driver(key: str, text: str) -> ModuleType:
    """Return the driver of a key, written to the cache folder before if need be."""
    name = f"mrsfi_compiled_{key}"
    if name in sys.modules:  # with what it has compiled
        return sys.modules[name]
    folder = cache_folder() / key
    path = folder / "flight.py"
    if not path.is_file():
        _make_room(folder.parent)
        folder.mkdir(parents=True, exist_ok=True)
        staged = folder / f"flight.{os.getpid()}.tmp"
        staged.write_text(text, encoding="utf-8")
        staged.replace(path)
    return load_module(name, path)
