"""A team's own node before a campaign: which faults reach it, and whether it repeats itself."""

from collections import defaultdict
from dataclasses import replace
from random import Random

from mrsfi.engines import Tell
from mrsfi_runtime.cosimulation.node_speech import Speech, out_of_reach
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import UsageError, counted
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.record.engine_settings import INJECTOR, EngineSettings
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.space import SearchSpace, random_specification

N_LOOKS = 3
"""Times that a specification is flown to see whether a node repeats itself, and if it does not."""


def within_reach(
    code: MissionCode, engine: EngineSettings, tell: Tell
) -> tuple[MissionCode, EngineSettings]:
    """Return code and settings without the faults that cannot be injected; tell of these.

    Where nothing is left, it is a ``UsageError``.
    """
    if engine.side != INJECTOR:
        return code, engine
    speech = Speech.of(engine.node_mapping, code.mission)
    beyond = out_of_reach(code.mission, code.pool, speech)
    touching = defaultdict(list)
    for fault, touched in beyond.items():
        touching[touched].append(fault)
    if touching:
        listed = "; ".join(f"{what} ({', '.join(faults)})" for what, faults in touching.items())
        tell(f"left out, for no topic tells your node of what they touch: {listed}")
    pool = code.pool.without(beyond)
    if not pool:
        raise UsageError(
            f"none of {counted(len(code.pool), 'faults')} can be injected: no topic of [node] "
            "tells of what they touch (docs/node.md)"
        )
    return replace(code, pool=pool), replace(engine, node_left_out=tuple(beyond))


def looked_at(
    code: MissionCode, engine: EngineSettings, settings: CampaignSettings, tell: Tell
) -> tuple[EngineSettings, str]:
    """Fly one specification several times, and return settings by which each flies often enough.

    That is once if the node repeats itself, and otherwise as often, as at a rate: then it is told
    and returned how it does not.
    """
    if engine.side != INJECTOR:
        return engine, ""
    space = SearchSpace.of(code.mission, code.pool)
    specification = random_specification(space, settings.faults, Random(settings.seed))
    with open_engine(engine, code, settings.mission_seed) as opened:
        found = [opened.evaluate(specification) for _ in range(N_LOOKS)]
    is_same = all(each == found[0] for each in found)
    counts = ", ".join(str(sum(each.believed)) for each in found)
    seen = f"one specification, flown {N_LOOKS} times, "
    seen += "was the same" if is_same else f"had {counts} believed violations"
    if is_same and not engine.is_free:
        tell(f"your node repeats itself: {seen}")
        return engine, ""
    how = "runs by its own clock" if engine.is_free else "does not repeat itself"
    doubt = (
        f"the external node {how}: {seen}; each is flown {N_LOOKS} times and judged by the "
        "median, and causes are not looked for: they may be chance"
    )
    tell(f"warning: {doubt}")
    return replace(engine, node_repeats=N_LOOKS), doubt
