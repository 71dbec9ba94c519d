"""What a server may be started with."""

import pytest

from mrsfi_runtime.bridge.settings import Settings
from mrsfi_runtime.errors import UsageError

TOKEN = "0123456789abcdef"


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "127.8.0.1"])
def test_addresses_of_this_machine_need_nothing(host):
    Settings(host).check()


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        (Settings("0.0.0.0"), "add --public and --token"),
        (Settings("::"), "add --public and --token"),
        (Settings("robot.example"), "add --public and --token"),
        (Settings("0.0.0.0", token=TOKEN), "add --public and --token"),
        (Settings("0.0.0.0", is_public=True), "needs a token"),
        (Settings("0.0.0.0", is_public=True, token="short"), "at least 16 letters"),
        (Settings(token="0123456789abcde?"), "at least 16 letters"),
    ],
)
def test_other_addresses_need_a_flag_and_a_token(settings, reason):
    with pytest.raises(UsageError, match=reason):
        settings.check()


def test_a_public_server_with_a_token_is_allowed():
    Settings("0.0.0.0", is_public=True, token=TOKEN).check()


def test_a_token_is_not_printed():
    assert TOKEN not in repr(Settings(token=TOKEN))
