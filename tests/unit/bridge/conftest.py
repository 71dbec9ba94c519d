"""What the clients of a server share, with a clock to move."""

import pytest

from tests.support.bridge import new_hub


@pytest.fixture
def hub_and_clock():
    return new_hub()


@pytest.fixture
def hub(hub_and_clock):
    return hub_and_clock[0]


@pytest.fixture
def clock(hub_and_clock):
    return hub_and_clock[1]
