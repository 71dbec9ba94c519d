"""Broken models: one edit of a flawless model for every constraint, and what it has to cause."""

from support_broken_sense import SENSE
from support_broken_structure import STRUCTURE
from support_broken_values import VALUES
from support_defect import Broken

BROKEN: list[Broken] = [*STRUCTURE, *VALUES, *SENSE]
