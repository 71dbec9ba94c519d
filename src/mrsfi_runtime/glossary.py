"""The glossary: every term of mrsfi in one sentence, with an example and the field's own term.

The page of a campaign shows these values as tooltips, and
``python -m docs.glossary docs/glossary.md`` writes the page of the documentation from them.
"""

from typing import NamedTuple


class Term(NamedTuple):
    """A term, its meaning in one sentence, an example, and neighbouring terms of the field."""

    name: str
    meaning: str
    example: str
    neighbour: str


TERMS = (
    Term(
        "collective intelligence",
        "The program that commands the robots, from messages alone; CI for short.",
        "The CI sends r3 a new heading after it received r3's position.",
        "mission controller, multi-robot planner",
    ),
    Term(
        "mission",
        "A model of robots, sensors, obstacles and goals, with a duration in ticks.",
        "models/uuv_sampling/mission.xmi",
        "scenario",
    ),
    Term(
        "tick",
        "One step of simulated time; the first is tick 0.",
        "A mission of 1000 ticks ends at tick 999.",
        "time step",
    ),
    Term(
        "flight",
        "One simulated run of a mission, with or without faults.",
        "`mrsfi simulate uuv_sampling` runs one flight.",
        "run, simulation, execution",
    ),
    Term(
        "true",
        "As it is in the simulated world.",
        "g2 is truly violated in 41 ticks: a robot was outside the mission area.",
        "ground truth",
    ),
    Term(
        "believed",
        "As the CI takes it to be, from the messages that it received.",
        "The CI believes that r3 stands still, because its position message is frozen.",
        "estimated state, belief state",
    ),
    Term(
        "goal",
        "What a mission has to achieve or avoid; mrsfi checks it at every tick, in truth and in "
        "belief.",
        "AvoidCollision (g1): no robot may touch another robot or an obstacle.",
        "safety goal, safety property",
    ),
    Term(
        "requirement",
        "What the team's specification demands, by its ID and text; goals of a mission stand for "
        "it, and it is violated if one of them fails.",
        "R1: In 10 s, the vehicle takes at least 20 measurements.",
        "requirement, spec object in ReqIF",
    ),
    Term(
        "severity",
        "Of a goal: how grave it is if the goal fails, from 1 to 10, as the team rates it.",
        "A vehicle without energy is lost: severity 9.",
        "severity of the effect, S in an FMEA",
    ),
    Term(
        "integrity level",
        "Of a goal: a class of the team's safety standard, by its name; it is never compared.",
        "ASIL B or SIL 2.",
        "ASIL, SIL, criticality level",
    ),
    Term(
        "violated",
        "Of a goal: not satisfied at a tick.",
        "g2 is violated at tick 882, when r3 leaves the mission area.",
        "property violation",
    ),
    Term(
        "fails",
        "Of a goal: it can no longer be met, whatever happens from that tick on; `missed` in files "
        "and options.",
        "g5 fails at tick 996: the 400 samples can no longer be reached.",
        "mission failure, unrecoverable violation",
    ),
    Term(
        "breaks",
        "Of faults: with them a goal is violated or fails; if it is so without faults already, "
        "for more than 5 % of the mission's ticks longer.",
        "A frozen position of KAL breaks StayWithinMissionArea (g2).",
        "triggers a failure",
    ),
    Term(
        "undetected",
        "Of a violation: true at a tick at which the CI does not believe it (`masked` in files and "
        "options); of a variant: believed at no tick from the first true violation on.",
        "r3 is outside the area for 20 ticks while the CI believes that it is inside.",
        "undetected violation, missed detection, false negative",
    ),
    Term(
        "detected",
        "Of a violation: the CI believes it, in time if at the tick at which it is first true, "
        "late if after it.",
        "The CI detects it late in 28 of 28 breaking variants, by up to 593 ticks.",
        "detection, diagnosed",
    ),
    Term(
        "false alarm",
        "A violation that the CI believes while there is none; `phantom` in files and options.",
        "A random energy report makes the CI believe that r3 runs out of energy.",
        "spurious detection, false positive",
    ),
    Term(
        "fault",
        "A fault type with a target, in the pool of a mission: it falsifies what the CI believes, "
        "delays or blocks messages, or forges a command.",
        "f11: FixedRobotCoordinates on r3's position in message m2.",
        "failure mode",
    ),
    Term(
        "pool",
        "All faults that a search may choose from, in faults.xmi.",
        "The pool of uuv_sampling has 30 faults.",
        "fault list, fault library",
    ),
    Term(
        "timed fault",
        "A fault with values and a window, from its start to its finish.",
        "f11 from tick 375 to 901, NEW_X 375.4, NEW_Y 279.6.",
        "fault instance",
    ),
    Term(
        "active",
        "Of a fault: inside its window, and triggered if it has a trigger.",
        "f3 is active for 501 ticks.",
        "injected",
    ),
    Term(
        "fault specification",
        "The timed faults of one flight; a search varies it.",
        "Evaluation 725 flew a specification of 20 timed faults.",
        "individual, test case, fault scenario",
    ),
    Term(
        "variant",
        "A fault, or a set of faults, with particular values and particular windows.",
        "Of 15 variants of f3 that were tried, 5 break g2.",
        "parameterisation, fault instance",
    ),
    Term(
        "weakness",
        "A goal and a minimal set of faults that breaks it: no part of the set does.",
        "AvoidCollision (g1) and {f11}.",
        "minimal cut set",
    ),
    Term(
        "mildest variant",
        "Of a weakness: the tried variant that is closest to the truth, is active for the fewest "
        "ticks, and still breaks the goal in three mission seeds.",
        "g2 fails if f3 is active for 501 ticks; no trial with up to 454 ticks made it fail.",
        "boundary case, minimal failure-inducing input",
    ),
    Term(
        "confirmed",
        "Of a weakness: it breaks the same goal in another world, at least as gravely; `mrsfi "
        "confirm` flies it there.",
        "13 of 14 weaknesses of mrsfi's own world break the same goal in Fossen's equations.",
        "cross-simulator validation, sim-to-real transfer",
    ),
    Term(
        "monitor",
        "A check of what the CI receives against its commands, the map or the data sheet; it "
        "raises an alarm while a measure exceeds a threshold.",
        "KAL's reported position is the same for more than one tick, although KAL should move.",
        "plausibility check, runtime monitor, safety mechanism",
    ),
    Term(
        "diagnostic coverage",
        "The share of the variants that truly break a goal that is detected in time.",
        "The CI's belief detects 55 % in time, with two monitors 100 %.",
        "diagnostic coverage (ISO 26262, IEC 61508)",
    ),
    Term(
        "cause set",
        "Of one specification: the faults without which its violations would not occur.",
        "6 of the 20 faults of evaluation 725 keep 95 % of its violations.",
        "minimal failure-inducing input (delta debugging)",
    ),
    Term(
        "joint",
        "Of faults: they break a goal only together.",
        "f21 and f30 break g2 together, and neither does alone.",
        "multi-point failure",
    ),
    Term(
        "campaign",
        "One search with everything that it recorded, in a folder of runs/.",
        "runs/uuv_sampling-a-1",
        "test campaign, fault injection campaign",
    ),
    Term(
        "evaluation",
        "A flight of a search, with its fitness, recorded under a number.",
        "Evaluation 725 has the highest fitness, 1257.50.",
        "fitness evaluation",
    ),
    Term(
        "fitness",
        "The number by which a search ranks evaluations: the more violations, the higher.",
        "Evaluation 725 has the highest fitness, 1257.50.",
        "objective, cost function",
    ),
    Term(
        "generation",
        "The evaluations that a search makes before it looks at their results and chooses the "
        "next.",
        "50 generations of at most 20 evaluations.",
        "iteration",
    ),
    Term(
        "Pareto front",
        "The evaluations of which none is better in one aim without being worse in another.",
        "Of 931 evaluations, 12 are trade-offs between g1 and g2.",
        "non-dominated set",
    ),
    Term(
        "harvest",
        "The flights after a search that isolate weaknesses and their variants.",
        "919 flights found 38 weaknesses of 6 goals.",
        "failure minimisation, test-case reduction",
    ),
    Term(
        "mission seed",
        "The number that decides everything random in a flight, such as which samples are valid.",
        "A weakness in 3 of 3 mission seeds does not depend on chance.",
        "random seed, replication",
    ),
    Term(
        "bound",
        "At most this share of random specifications without the listed weaknesses breaks the "
        "goal, with 95 % confidence.",
        "At most 35 % of other random specifications make g2 fail (0 of 7 did).",
        "upper confidence limit",
    ),
    Term(
        "margin",
        "How far a goal was from its violation, at its closest tick; below 0, how far it was "
        "beyond its limit, at worst.",
        "12050 energy units above its limit at tick 999.",
        "robustness degree, safety margin",
    ),
    Term(
        "kept weakness",
        "A specification stored beside the models, with limits that `mrsfi check` compares.",
        "case_a_1: g2 at most 698 believed violations.",
        "regression test",
    ),
    Term(
        "setup",
        "A search algorithm with its settings, as `mrsfi compare` compares it.",
        "Population 40 against population 20.",
        "configuration, treatment",
    ),
    Term(
        "engine",
        "The part that simulates flights: compiled, reference or rosbridge, with the same results.",
        "`--engine rosbridge`",
        "simulator backend",
    ),
    Term(
        "region",
        "A marked part of generated code that keeps your changes when it is generated again.",
        "`# protected region g1.check on begin`",
        "protected region (Acceleo, EGL)",
    ),
    Term(
        "digest",
        "A SHA-256 of everything that a flight or a campaign recorded; equal digests mean equal "
        "results.",
        "3966486e…",
        "checksum, fingerprint",
    ),
)
"""In the order in which a reader needs them."""
