"""How near to a limit is at it: no verdict turns on the last bit of a sum.

Checks take what differs from a limit by less than a billionth of it for equal; reactions keep
farther away from limits than that.
"""

from mrsfi_runtime.kernel.compiling import kernel

TOLERANCE = 1e-9
"""Share of a limit, or of a distance unit, below which a difference is none."""

RESERVE = 0.001
"""Share of a limit that reactions leave unused: of an area's radius, and of energy."""


@kernel
def excess(value: float, limit: float) -> float:
    """Return by how much a value exceeds a limit, >= 0; negative if it falls short of it.

    It is 0 where the two differ by no more than ``TOLERANCE`` × limit.
    """
    difference = value - limit
    return 0.0 if abs(difference) <= TOLERANCE * limit else difference
