"""Somebody else's simulation has to repeat itself before a cause can be told from chance."""

from itertools import cycle

from mrsfi.explaining import NamedSpecification, require_repeatable
from mrsfi_runtime.errors import ReplayMismatch
from tests.support.campaigns import outcome

SUBJECT = NamedSpecification("best", "evaluation 3", (), ())


class Simulation:
    """Finds one outcome after the other."""

    def __init__(self, *outcomes):
        self._outcomes = cycle(outcomes)

    def evaluate(self, specification):
        assert specification == SUBJECT.specification
        return next(self._outcomes)


def test_one_that_flies_differently_is_refused(refused):
    with refused(ReplayMismatch):
        require_repeatable(Simulation(outcome([7]), outcome([8])), SUBJECT)


def test_one_that_repeats_itself_is_not():
    require_repeatable(Simulation(outcome([7])), SUBJECT)
