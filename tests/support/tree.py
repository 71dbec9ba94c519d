"""Where the tree lies that is tested."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

UNDRAWN = ROOT / "tests" / "support" / "undrawn"
"""On the path of a process, it has figures left empty, where nobody looks at them."""
