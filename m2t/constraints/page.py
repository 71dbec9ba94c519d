"""The page of docs/ that lists all constraints."""

from m2t.diagnostics import CONSTRAINTS, Constraint
from m2t.fixes import FIXES

_PAGE = """# Constraints

Made from `CONSTRAINTS` in `m2t/diagnostics.py`; do not edit. After a change, write it anew:

```sh
python -c "import m2t.constraints.page as p; print(p.constraints_page(), end='')" \\
    > docs/constraints.md
```

`mrsfi validate MISSION` checks all of them. Those with a file in the last column are stated
in EVL as well, beside the metamodels, with the same name, severity and message: an error is a
`constraint`, a warning a `critique`. In Eclipse, run `metamodels/faults.evl` with
[Epsilon](epsilon.md) on the fault model, which brings its mission, or `metamodels/mission.evl`
on a mission alone; the first imports the second, and both import what stands in
`metamodels/constraints/`.
`tests/interop` compares both sides, constraint by constraint.

Structure is checked before sense: what a constraint would say about missing parts helps nobody.
Messages of EVL know no line numbers. Where a model is spelt otherwise than Eclipse writes it,
they quote numbers as Eclipse would write them (`-5.0`, not `-5`).

| constraint | severity | meaning | fix | EVL |
|---|---|---|---|---|
{rows}

## Why some are not stated in EVL

{reasons}
- `FaultFreeMission` (warning) and `MissionFlies` (error) need a flight, and so `mrsfi validate`: a
  goal is violated although nothing fails; the mission's own code fails.
- `RegionFilled`, `RegionRuns` (errors) and `RegionCompilesAlike` (a warning) are said of regions of
  the generated code, not of models, by `mrsfi validate` alone: a goal task or an effect of your
  own has empty regions until you fill them; a line cannot run; [the compiled
  engine](compiled.md) makes something else of it.
- `ResolvedReference` is stated for references to other files; a dangling one within its own file
  makes Eclipse refuse it, or drop the reference without a word if it has a colon.

## Fixes

`mrsfi validate MISSION --fix` mends what has one sensible remedy: it shows the change as a
diff, asks, and writes the file as Eclipse would. Epsilon offers the same remedies under the
same titles as quick fixes, and writes the same bytes. A repeated reference is mended by loading
and saving alone. Where the structure of the faults is broken, `--fix` waits until it is mended;
Epsilon already offers to fix the mission.

Where a robot, a sensor, a server or anything else was deleted, `--fix` deletes the references to
it, and what is incomplete without them: a goal loses a member, a message goes with its sender,
a fault with its message. All of it stands in the diff first. Other fixes follow in a second
run; Epsilon offers no such fix.
"""


def constraints_page() -> str:
    """Return the page, in Markdown, with every constraint in the order of its checks."""
    rows = "\n".join(_row(name, constraint) for name, constraint in CONSTRAINTS.items())
    by_reason: dict[str, list[str]] = {}
    for name, constraint in CONSTRAINTS.items():
        if constraint.reason:
            by_reason.setdefault(constraint.reason, []).append(f"`{name}`")
    reasons = "\n".join(
        f"- {reason[0].upper()}{reason[1:]}:\n  {', '.join(names)}."
        for reason, names in by_reason.items()
    )
    return _PAGE.format(rows=rows, reasons=reasons)


def _row(name: str, constraint: Constraint) -> str:
    fix = FIXES[name].title if name in FIXES else ""
    evl = f"`{constraint.evl}`" if constraint.evl else "none"
    return f"| `{name}` | {constraint.severity} | {constraint.meaning} | {fix} | {evl} |"
