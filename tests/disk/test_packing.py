"""What is no archive of a campaign, whatever is wrong with it."""

import re
import zipfile

import pytest

from mrsfi.packing import repeat
from mrsfi_runtime.errors import RecordError

LOCAL, CENTRAL = b"PK\3\4", b"PK\1\2"


def with_entries(content, flags, method):
    """Return an archive whose only entry says other flags and another way of compression."""
    for signature, place in ((LOCAL, 6), (CENTRAL, 8)):
        start = content.index(signature) + place
        told = flags.to_bytes(2, "little") + method.to_bytes(2, "little")
        content = content[:start] + told + content[start + 4 :]
    return content


SPOILED = {
    "no archive": lambda _: b"PK nothing",
    "cut": lambda content: content[:-40],
    "noise inside": lambda content: content[:60] + b"\xff" * 40 + content[100:],
    "encrypted": lambda content: with_entries(content, 1, 8),
    "compressed in no known way": lambda content: with_entries(content, 0, 99),
    "compressed by something else": lambda content: with_entries(content, 0, 14),
}


@pytest.mark.parametrize("name", SPOILED)
def test_what_is_no_archive_is_refused_by_its_name(name, tmp_path):
    path = tmp_path / "run.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("campaign/campaign.sqlite", bytes(range(256)) * 20)
    path.write_bytes(SPOILED[name](path.read_bytes()))

    with pytest.raises(RecordError, match=re.escape(f"{path}: is no archive of a campaign (")):
        repeat(path, lambda _: pytest.fail("nothing is flown"))


@pytest.mark.parametrize("name", ["campaign/mission.xmi", "../campaign/campaign.sqlite"])
def test_an_archive_of_something_else_is_refused_by_the_place_in_it(name, tmp_path):
    path = tmp_path / "run.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(name, b"something else")

    with pytest.raises(RecordError, match=re.escape(f"{path}/campaign")):
        repeat(path, lambda _: pytest.fail("nothing is flown"))

    assert [each.name for each in tmp_path.iterdir()] == ["run.zip"]
