"""A plugin of pytest that ends its process once the results are written.

The event loop of roslibpy on Twisted now and then keeps a process alive whose tests have all ended.
"""

import os
import sys

import pytest

_STATUS = pytest.StashKey[int]()


def pytest_sessionfinish(session, exitstatus):
    """Note the result."""
    session.config.stash[_STATUS] = int(exitstatus)


def pytest_unconfigure(config):
    """End the process, after the other plugins have written what they write."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(config.stash.get(_STATUS, pytest.ExitCode.INTERNAL_ERROR))
