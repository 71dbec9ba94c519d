"""What would have caught the weaknesses of a campaign: monitors, fitted, measured, recommended.

``monitored`` flies for ``causes/monitors.py``, which judges; the rest renders its ``Study``.
"""

import math
import os
import re
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from m2t.emit import parse, template_environment
from mrsfi.campaign_folders import mission_of, open_campaign
from mrsfi.engines import Given, Tell, now_and_then, silent
from mrsfi.explaining import flying_again, harvested
from mrsfi.folders import load_fresh
from mrsfi_runtime.analysis.tables import Cell, Table
from mrsfi_runtime.analysis.weaknesses import in_percent, monitors_in_words
from mrsfi_runtime.causes.consequences import STAGES, Coverage
from mrsfi_runtime.causes.harvest import ADVICE
from mrsfi_runtime.causes.monitors import (
    Study,
    Watch,
    breaking,
    cases,
    coverage,
    formulas,
    n_raised,
)
from mrsfi_runtime.causes.weakness import timed_as_json
from mrsfi_runtime.engine.recording import Recording
from mrsfi_runtime.errors import ReplayMismatch, UsageError, counted
from mrsfi_runtime.files import changing
from mrsfi_runtime.kernel.state import is_kernel
from mrsfi_runtime.model.fault_types import Range, plain_name
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import COUNTED, Outcome
from mrsfi_runtime.monitors import MONITORS, Monitor
from mrsfi_runtime.record.database import CampaignFolder, only_writer
from mrsfi_runtime.record.engine_settings import INJECTOR, Workers
from mrsfi_runtime.record.settings import following
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.fitness import errors_by_line, imported
from mrsfi_runtime.search.space import SearchSpace

N_FRESH = 20
"""Mission seeds, after those that fit thresholds, in which false alarms are counted."""


def monitored(run: Path, engine: Given, n_fit: int, tell: Tell = silent) -> Study:
    """Study monitors for a campaign, fitted in ``n_fit`` mission seeds from the campaign's on.

    The campaign keeps which monitors to add, for its page and its FMEA. A flight of the search that
    differs from its record is a ``ReplayMismatch``.
    """
    with flying_again(run, engine, Workers(1), tell) as (campaign, _, own):
        seed = campaign.store.settings.mission_seed
        known, mission = harvested(campaign), campaign.mission
        fit, fresh = (
            following(seed, n_fit + N_FRESH)[part] for part in (slice(n_fit), slice(n_fit, None))
        )
        variants = breaking(SearchSpace.of(mission, campaign.pool), known)
        broken = known.known.flown
        single = (each for each in known.outcomes if len(each) == 1 and not broken[each])
        harmless = {each[0].fault: each for each in single}
        n_flights = n_fit + N_FRESH + len(variants) + len(harmless)
        n_begun, tell_of = count(1), now_and_then(tell)

        def record(specification: Specification, each: int = seed) -> Recording:
            tell_of(partial("monitors   flight {} of {}".format, next(n_begun), n_flights))
            return own.record(specification, each)

        def again(specification: Specification) -> Recording:
            flight = record(specification)
            _require_same(run, specification, known.outcomes[specification], flight)
            return flight

        tell(f"monitors   {counted(n_flights, 'flights')}, {n_fit + N_FRESH} without faults")
        with errors_by_line(f"{_OWN}: MONITORS"):
            flights = ((each, record((), each)) for each in fit)
            watch = Watch.fitted(mission, (*MONITORS, *own_monitors()), flights)
        judged = tuple(cases(mission, variants, again, partial(watch.alarms, seed)))
        study = Study(
            watch,
            judged,
            tuple(watch.alarms(each, record((), each)) for each in fresh),
            tuple(watch.alarms(seed, again(each)) for each in harmless.values()),
            campaign.store.n_evaluations,
        )
    if judged and os.access(run, os.W_OK):
        with only_writer(CampaignFolder(run)), CampaignStore.open(run) as store:
            store.keep(ADVICE, study.advice.text())
    return study


def _require_same(
    run: Path, specification: Specification, recorded: Outcome, flight: Recording
) -> None:
    """Compare the counts of a flight with the record."""
    for name in COUNTED:
        now, then = tuple(flight[name][-1].tolist()), getattr(recorded, name)
        if now != then:
            faults = ", ".join(each.fault for each in specification)
            raise ReplayMismatch(
                f"{run}: a flight under {faults} differs from its record: {name} {now}, recorded "
                f"{then}; expected the same; check whether the external simulation or node, mrsfi, "
                "or the kind of processor has changed since"
            )


def require_regions(run: Path) -> None:
    """Refuse a campaign of a node, for which no region of generated code reacts."""
    with CampaignStore.open(run) as store:
        if store.manifest.engine.side == INJECTOR:
            raise UsageError(
                f"{run}: was flown with a node, and --write adds monitors to generated reactions; "
                "expected no --write: --json has thresholds and formulas for your node"
            )


_OWN = Path("monitors.py")


def own_monitors() -> tuple[Monitor, ...]:
    """Return ``MONITORS`` of the module ``monitors.py`` in the current folder, if there is one."""
    if not _OWN.is_file():
        return ()
    listed = getattr(imported(_OWN.stem, str(_OWN)), "MONITORS", None)
    monitors = listed if isinstance(listed, tuple) else (listed,)
    names = [each.name for each in MONITORS]
    for each in monitors:
        if not isinstance(each, Monitor) or not is_kernel(each.measure) or each.name in names:
            found = getattr(each, "name", each)
            raise UsageError(
                f"{_OWN}: found {found!r} in MONITORS; expected a tuple of Monitor, each with a "
                "name of its own and a function marked @kernel"
            )
        names.append(each.name)
    return monitors


def write(run: Path, study: Study) -> Path:
    """Write the recommended monitors into regions of the mission's code, or change none of it.

    Monitors that were written before are replaced, a reaction to their alarms is kept.
    """
    if not study.recommended:
        raise UsageError(
            f"{run}: found no monitor to write; expected one that detects more in time"
        )
    with open_campaign(run) as campaign:
        folders = mission_of(campaign)
    path = folders.generated / "collective_intelligence.py"
    with changing(folders.models) as change:
        if load_fresh(folders).mission != study.watch.mission:
            what = f"{folders.models}: differs from the mission of {run}"
            raise UsageError(f"{what}; expected the same: run `mrsfi evolve` on it first")
        change.replace({path: _with_monitors(path, study).encode()})
    return path


_BLOCK = re.compile(r"# Monitors, as `mrsfi.*?# End of the monitors\.\n", re.DOTALL)


def _with_monitors(path: Path, study: Study) -> str:
    """Return the text of a collective intelligence with the recommended monitors."""
    names = {each.monitor for each in study.recommended}
    monitors = [each for each in study.watch.monitors if each.name in names]
    file = parse(path.read_text(encoding="utf-8"), str(path))
    bodies = {id: region.body for id, region in file.regions.items()}
    helpers = _BLOCK.sub("", bodies["helpers"])
    context = [
        {
            "constant": plain_name(each.name).upper(),
            "limits": tuple(study.watch.thresholds[each.name].values()),
            "unit": each.unit.value,
            "elements": each.elements,
            "measure": f"{'monitors.' * (each in MONITORS)}{each.measure.__name__}",
            "place": place,
            "is_lasting": each.unit is Range.TICKS,
        }
        for place, each in enumerate(monitors)
    ]
    template = template_environment().get_template("monitors.py.j2")
    written = template.render(monitors=context, written=re.findall(r"def (\w+)", helpers))
    bodies["helpers"] = written + helpers
    call, reactions = "    check_monitors(ci)\n", [id for id in bodies if id.endswith(".react")]
    for id in reactions:  # another goal may have been the first before
        bodies[id] = bodies[id].replace(call, "")
    added = {reactions[0]: [call], "imports": ["from mrsfi_runtime.api import monitors\n"]}
    for each in monitors:
        if each not in MONITORS:
            module, name = each.measure.__module__, each.measure.__name__
            added["imports"].append(f"from {module} import {name}\n")
    for id, lines in added.items():
        bodies[id] = "".join(each for each in lines if each not in bodies[id]) + bodies[id]
    return "".join(
        part if isinstance(part, str) else f"{part.begin}{bodies[part.id]}{part.end}"
        for part in file.parts
    )


def sentences(study: Study) -> Iterator[str]:
    """Yield which monitors to add, what each gives, then what is not detected in time, and why."""
    if not study.cases:
        yield "No weakness truly breaks a goal."
        return
    mission, advice = study.watch.mission, study.advice
    for number, step in enumerate(monitors_in_words(mission, advice), 1):
        yield f"{number}. {step}"
    names = [each.monitor for each in advice.steps]
    yield f"False alarms of these: in {advice.n_false} of {advice.n_fresh} fresh mission seeds"
    left = [each for each in study.cases if each.stage(names)]
    yield f"They do not detect in time: {len(left)} of {len(study.cases)} breaking variants"
    for weakness in dict.fromkeys(each.weakness for each in left):
        late_by = [each.detected(names) - each.broken for each in left if each.weakness == weakness]
        ticks = [int(each) for each in late_by if each < math.inf]
        n_never, faults = len(late_by) - len(ticks), " and ".join(weakness.faults)
        why = [f"no alarm in {counted(n_never, 'variants')}"] * bool(n_never)
        if ticks:
            latest = study.watch.mission.units.ticks(max(ticks))
            why.append(f"a late one in {counted(len(ticks), 'variants')}, by up to {latest}")
        yield f"Weakness {weakness.number} ({weakness.goal}, {faults}): {'; '.join(why)}"


def tables(study: Study) -> Iterator[Table]:
    """Yield the coverage of each goal and requirement, and a row for each monitor."""
    mission, names = study.watch.mission, [each.monitor for each in study.recommended]
    goals = {mission.label_of(goal.id): {goal.id} for goal in mission.goals}
    for each in mission.requirements:
        some = (goal.id for goal in mission.goals if each.id in goal.requirements)
        goals[f"requirement {each.id}"] = {*some}
    rows = list[Sequence[Cell]]()
    for name, group in goals.items():
        if judged := [each for each in study.cases if each.weakness.goal in group]:
            both = (coverage(judged, ()), coverage(judged, names))
            rows.append((name, len(judged), *(cell for one in both for cell in _in_words(one))))
    title = "Diagnostic coverage: the share of breaking variants that is detected in time"
    words = ("belief", "class", "with these", "class then")
    yield Table(title, ("goal", "variants", *words), rows, words, ("goal",), is_compact=True)
    rows = []
    for name, threshold in [("none", ""), *_thresholds(study)]:
        shares = coverage(study.cases, [name])[: len(STAGES)]
        flights = (study.fresh, study.harmless)
        counts = [f"{n_raised(some, [name])} of {len(some)}" for some in flights]
        rows.append((name, threshold, *map(in_percent, shares), *counts))
    title = "Each monitor beside the CI's belief: when variants are detected, and other alarms"
    columns = ("monitor", "alarm above", *STAGES, "false alarms", "harmless faults")
    yield Table(title, columns, rows, ("monitor",), ("alarm above",), is_compact=True)


def _in_words(coverage: Coverage) -> tuple[str, str]:
    ends = f"{100 * coverage.low:.0f} to {in_percent(coverage.high)}"
    return f"{in_percent(coverage.in_time)} ({ends})", coverage.level


def _thresholds(study: Study) -> Iterator[tuple[str, str]]:
    """Yield monitors of at least one element, with the ends of their thresholds and the unit."""
    units = study.watch.mission.units
    for monitor in study.watch.monitors:
        if values := sorted(study.watch.thresholds[monitor.name].values()):
            low, high = (units.quantity(end, monitor.unit) for end in (values[0], values[-1]))
            least = "" if low == high else f"{low.split()[0]} to "
            if monitor.unit is Range.TICKS:
                high = units.ticks(int(values[-1]))
            elif monitor.unit is Range.X and not units.distance:
                high += " units"
            yield monitor.name, least + high


def as_json(study: Study) -> dict[str, Any]:
    """Return the study as plain values; a tick is null for never."""
    steps = study.recommended
    names = [each.monitor for each in steps]
    judged = []
    for each in study.cases:
        about = {"weakness": each.weakness.number, "goal": each.weakness.goal}
        about["variant"] = [*map(timed_as_json, each.variant)]
        ticks = (("broken", each.broken), ("failed", each.failed), ("believed", each.believed))
        about |= {name: None if tick == math.inf else int(tick) for name, tick in ticks}
        about |= {"weight": each.weight, "alarms": each.alarms}
        judged.append(about | {"stage": STAGES[each.stage(names)]})
    return {
        "thresholds": study.watch.thresholds,
        "belief": coverage(study.cases, ())._asdict() if study.cases else None,
        "recommended": [
            each._asdict()
            | {"coverage": each.coverage._asdict()}
            | {"formulas": formulas(study.watch, each.monitor)}
            for each in steps
        ],
        "cases": judged,
        "fresh": study.fresh,
        "harmless": study.harmless,
    }
