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
    "settings",
    [
        ServerSettings("0.0.0.0"),
        ServerSettings("::"),
        ServerSettings("robot.example"),
        ServerSettings("0.0.0.0", token=TOKEN),
        ServerSettings("0.0.0.0", is_public=True),
        ServerSettings("0.0.0.0", is_public=True, token="short"),
        ServerSettings(token="0123456789abcde?"),
    ],
)
def test_other_addresses_without_them_are_refused(settings, refused):
    with refused(SettingsError):
        settings.check()


def test_a_token_is_not_printed():
    assert TOKEN not in repr(ServerSettings(token=TOKEN))
