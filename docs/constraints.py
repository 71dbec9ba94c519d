"""Write the table of all constraints, and why EVL does not state some, into a page of text.

Examples
--------
``python -m docs.constraints docs/constraints.md``
"""

import re
import sys
from pathlib import Path

from m2t.diagnostics import CONSTRAINTS, Constraint
from m2t.models.fixes import FIXES

_ROWS = re.compile(r"(?<=\|---\|\n)(\|.*\n)*")
_REASONS = re.compile(r"(?<=not stated in EVL\n\n)(- [^`].*\n  .*\n)*")


def constraints_page(page: str) -> str:
    """Return a page, in Markdown, with every constraint in the order of its checks."""
    rows = "".join(_row(name, constraint) for name, constraint in CONSTRAINTS.items())
    by_reason: dict[str, list[str]] = {}
    for name, constraint in CONSTRAINTS.items():
        if constraint.reason:
            by_reason.setdefault(constraint.reason, []).append(f"`{name}`")
    reasons = "".join(
        f"- {reason[0].upper()}{reason[1:]}:\n  {', '.join(names)}.\n"
        for reason, names in by_reason.items()
    )
    return _REASONS.sub(lambda _: reasons, _ROWS.sub(lambda _: rows, page))


def _row(name: str, constraint: Constraint) -> str:
    fix = FIXES[name].title if name in FIXES else ""
    evl = f"`{constraint.evl}`" if constraint.evl else "none"
    return f"| `{name}` | {constraint.severity} | {constraint.meaning} | {fix} | {evl} |\n"


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.write_text(constraints_page(path.read_text("utf-8")), "utf-8", newline="\n")
