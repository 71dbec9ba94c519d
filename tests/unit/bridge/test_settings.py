"""What a server may be started with."""

import pytest

from mrsfi_bridge.errors import SettingsError
from mrsfi_bridge.settings import ServerSettings

TOKEN = "0123456789abcdef"


@pytest.mark.parametrize(
    "settings",
    [
        *map(ServerSettings, ("127.0.0.1", "localhost", "::1", "127.8.0.1")),
        ServerSettings("0.0.0.0", is_public=True, token=TOKEN),
    ],
)
def test_addresses_of_this_machine_need_nothing_and_others_a_flag_and_a_token(settings):
    settings.check()


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        (ServerSettings("0.0.0.0"), "add --public and --token"),
        (ServerSettings("::"), "add --public and --token"),
        (ServerSettings("robot.example"), "add --public and --token"),
        (ServerSettings("0.0.0.0", token=TOKEN), "add --public and --token"),
        (ServerSettings("0.0.0.0", is_public=True), "needs a token"),
        (ServerSettings("0.0.0.0", is_public=True, token="short"), "at least 16 letters"),
        (ServerSettings(token="0123456789abcde?"), "at least 16 letters"),
    ],
)
def test_other_addresses_without_them_are_refused(settings, reason):
    with pytest.raises(SettingsError, match=reason):
        settings.check()


def test_a_token_is_not_printed():
    assert TOKEN not in repr(ServerSettings(token=TOKEN))
