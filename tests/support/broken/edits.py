"""Broken models: one edit of a flawless model for every constraint, and what it has to cause."""

from tests.support.broken.defect import Broken
from tests.support.broken.sense import SENSE
from tests.support.broken.structure import STRUCTURE
from tests.support.broken.values import VALUES

BROKEN: list[Broken] = [*STRUCTURE, *VALUES, *SENSE]
