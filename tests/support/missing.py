"""What a test does when a part of it is missing here."""

import os
from typing import NoReturn

import pytest


def skip(reason: str) -> NoReturn:
    """Skip the test; in continuous integration, where every part belongs, fail it."""
    if os.environ.get("MRSFI_CI"):
        pytest.fail(reason)
    pytest.skip(reason)
