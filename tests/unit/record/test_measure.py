import pytest

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.measures import MEANS
from tests.support.search import paper_mission


@pytest.mark.parametrize(
    ("settings", "goals", "message"),
    [
        (CampaignSettings(), ("g1", "g9"), "found goal 'g9'; .* g1, g2, g3, g4, g5, g6"),
        (MEANS, ("g1", "g2"), "found goal 'g2'; .* mission seeds .* only: g1, g3"),
    ],
)
def test_goals_that_a_record_says_nothing_of_are_refused(settings, goals, message):
    with pytest.raises(UsageError, match=message):
        Measure.of(settings, paper_mission()).require(goals)
