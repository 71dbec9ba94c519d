"""Unit vectors of whole degrees: the only trigonometry of the kernel.

A table reads the same in the interpreter and in compiled code, where ``math.sin`` need not.
States carry it, because a compiler would copy a constant tuple at every use.
"""

import math

from mrsfi_runtime.kernel.state import DirectionState

N_DIRECTIONS = 360

DIRECTIONS = tuple(
    DirectionState(math.cos(math.radians(degrees)), math.sin(math.radians(degrees)))
    for degrees in range(N_DIRECTIONS)
)
