"""Unit vectors of whole degrees: the only trigonometry of the kernel.

A table reads the same in the interpreter and in compiled code, where ``math.sin`` need not.
"""

import math

N_DIRECTIONS = 360

COSINES = tuple(math.cos(math.radians(degrees)) for degrees in range(N_DIRECTIONS))
SINES = tuple(math.sin(math.radians(degrees)) for degrees in range(N_DIRECTIONS))
