"""What is no archive of a campaign, whatever is wrong with it."""

import zipfile
from hashlib import sha256

import pytest

from mrsfi.campaign import repeat
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
    "with a name that is no UTF-8": lambda content: with_entries(
        content.replace(b".sqlite", b".\xffqlite"), 0x800, 8
    ),
}


@pytest.mark.parametrize("name", SPOILED)
def test_what_is_no_archive_is_refused_by_its_name(name, tmp_path, refused):
    path = tmp_path / "run.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("campaign/campaign.sqlite", bytes(range(256)) * 20)
    path.write_bytes(SPOILED[name](path.read_bytes()))

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))


def listed(**members):
    """Return members of an archive with a list that fits them."""
    lines = [f"{sha256(content).hexdigest()}  {name}\n" for name, content in members.items()]
    return members | {"SHA256SUMS": "".join(lines).encode(), "REPRODUCE.md": b""}


def write(path, members):
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members:
            archive.writestr(name, content)


@pytest.mark.parametrize("name", ["campaign/mission.xmi", "../campaign/campaign.sqlite"])
def test_an_archive_of_something_else_is_refused_and_nothing_lands_beside_it(
    name, tmp_path, refused
):
    path = tmp_path / "run.zip"
    write(path, listed(**{name: b"something else"}).items())

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))

    assert [each.name for each in tmp_path.iterdir()] == ["run.zip"]


def test_an_archive_without_a_list_of_hashes_is_none_of_a_campaign(tmp_path, refused):
    path = tmp_path / "run.zip"
    write(path, [("campaign/campaign.sqlite", b"")])

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_member_that_is_there_twice_is_refused(tmp_path, refused):
    path, members = tmp_path / "run.zip", listed(x=b"")
    write(path, [*members.items(), ("x", b"")])

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))
