"""A seeded fuzzer: breaks model files as disks, editors, merges and attackers do."""

import random
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE, metamodel_folder, read_metamodels

Mutilation = Callable[[bytes, random.Random], bytes]

_BOMB = b"""<!DOCTYPE m [<!ENTITY a "lol"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;">]>
"""
_VALUES = [
    b"", b" ", b"-1", b"0", b"1e999", b"NaN", b"2147483648", b"true", b"x", b"#//x", b"#", b"/",
    b"//@robots.99", b"//@robots.-1", b"mission.xmi#", b"mission.xmi#//@goals.0", b"robots.xmi#r1",
    b"../../../x#a", b"file:///x#a", b"http://example.org/x#a", b"platform:/resource/x/y#a",
    b"&#0;", b"&#xD800;", b"&lol;", b"\xff\xfe", "\N{SNOWMAN}".encode(), b"a" * 5000,
    b"mission:Mission", b"ecore:EClass", b"#//Mission", b"#//Robot #//Robot", b"class", b"None",
]  # fmt: skip


def _cut(text: bytes, draw: random.Random) -> bytes:
    return text[: draw.randrange(len(text))]


def _drop_span(text: bytes, draw: random.Random) -> bytes:
    start = draw.randrange(len(text))
    return text[:start] + text[start + draw.randint(1, 200) :]


def _double_span(text: bytes, draw: random.Random) -> bytes:
    start = draw.randrange(len(text))
    end = start + draw.randint(1, 400)
    return text[:end] + text[start:end] + text[end:]


def _flip_byte(text: bytes, draw: random.Random) -> bytes:
    position = draw.randrange(len(text))
    return text[:position] + bytes([draw.randrange(256)]) + text[position + 1 :]


def _drop_line(text: bytes, draw: random.Random) -> bytes:
    lines = text.splitlines(keepends=True)
    del lines[draw.randrange(len(lines))]
    return b"".join(lines)


def _double_line(text: bytes, draw: random.Random) -> bytes:
    lines = text.splitlines(keepends=True)
    position = draw.randrange(len(lines))
    lines.insert(position, lines[position])
    return b"".join(lines)


def _swap_lines(text: bytes, draw: random.Random) -> bytes:
    lines = text.splitlines(keepends=True)
    first, second = draw.randrange(len(lines)), draw.randrange(len(lines))
    lines[first], lines[second] = lines[second], lines[first]
    return b"".join(lines)


def _replace_one(pattern: bytes, text: bytes, new: bytes, draw: random.Random) -> bytes:
    found = draw.choice(list(re.finditer(pattern, text)))
    return text[: found.start(1)] + new + text[found.end(1) :]


def _retype_value(text: bytes, draw: random.Random) -> bytes:
    return _replace_one(rb'="([^"]*)"', text, draw.choice(_VALUES), draw)


def _exchange_values(text: bytes, draw: random.Random) -> bytes:
    values = [found.group(1) for found in re.finditer(rb'="([^"]*)"', text)]
    return _replace_one(rb'="([^"]*)"', text, draw.choice(values), draw)


def _rename_attribute(text: bytes, draw: random.Random) -> bytes:
    names = [found.group(1) for found in re.finditer(rb" ([\w:]+)=", text)]
    return _replace_one(rb" ([\w:]+)=", text, draw.choice([*names, b"href", b"xmi:id"]), draw)


def _rename_element(text: bytes, draw: random.Random) -> bytes:
    names = [found.group(1) for found in re.finditer(rb"<([\w:]+)", text)]
    return _replace_one(rb"<([\w:]+)[^>]*/>", text, draw.choice(names), draw)


def _drop_attribute(text: bytes, draw: random.Random) -> bytes:
    return _replace_one(rb'( [\w:]+="[^"]*")', text, b"", draw)


def _wrong_namespace(text: bytes, draw: random.Random) -> bytes:
    wrong = draw.choice([b"http://example.org/x", b"", b"http://www.omg.org/XMI", b"urn:a b"])
    return _replace_one(rb'xmlns:\w+="([^"]*)"', text, wrong, draw)


def _entity_bomb(text: bytes, draw: random.Random) -> bytes:
    bombed = _replace_one(rb'="([^"]*)"', text, b"&d;" * draw.randint(1, 50), draw)
    return bombed.replace(b"?>\n", b"?>\n" + _BOMB, 1)


def _deep_nesting(text: bytes, draw: random.Random) -> bytes:
    name = draw.choice([b"a", b"robots", b"eClassifiers", b"eAnnotations", b"center"])
    depth = draw.choice([5, 99, 101, 20_000])
    nest = b"<%s>" % name * depth + b"</%s>" % name * depth
    return _replace_one(rb">(\n)", text, nest, draw)


def _wrong_encoding(text: bytes, draw: random.Random) -> bytes:
    name = draw.choice([b"UTF-16", b"UTF-7", b"rot13", b"EBCDIC-CP-US", b"x", b"hex", b"big5"])
    return _replace_one(rb'encoding="([^"]*)"', text, name, draw)


def _other_bytes(text: bytes, draw: random.Random) -> bytes:
    return text.decode("utf-8").encode(draw.choice(["utf-16", "utf-32", "utf-16-le", "cp037"]))


def _insert_noise(text: bytes, draw: random.Random) -> bytes:
    noise = draw.choice(
        [b"<!-- c -->", b"<?p i?>", b"text", b"<![CDATA[x]]>", b"<x/>", b"&amp;", b"]]>", b"\x00"]
    )
    return _replace_one(rb">(\n)", text, noise, draw)


def _empty(text: bytes, draw: random.Random) -> bytes:
    return draw.choice([b"", b"\n", b"\xef\xbb\xbf", text[:1], b"{}", b"\x00" * len(text)])


def _doubled(text: bytes, draw: random.Random) -> bytes:
    return text + text[draw.choice([0, text.index(b"?>\n") + 3]) :]


def _several(text: bytes, draw: random.Random) -> bytes:
    for _ in range(draw.randint(2, 5)):
        text = draw.choice(_SMALL)(text, draw)
    return text


_SMALL: list[Mutilation] = [_retype_value, _exchange_values, _drop_attribute, _swap_lines]

MUTILATIONS: Mapping[str, Mutilation] = {
    way.__name__.removeprefix("_"): way
    for way in (
        *(_cut, _drop_span, _double_span, _flip_byte, _drop_line, _double_line, _swap_lines),
        *(_retype_value, _exchange_values, _rename_attribute, _rename_element, _drop_attribute),
        *(_wrong_namespace, _entity_bomb, _deep_nesting, _wrong_encoding, _other_bytes),
        *(_insert_noise, _empty, _doubled, _several),
    )
}
"""All ways to break a file; each takes its bytes and a source of random draws."""


def content(folder: Path) -> dict[str, bytes]:
    """Return every file below a folder."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Lead the code to metamodels of its own, as an installation elsewhere would; their folder."""
    folder = tmp_path / "m2t" / "metamodels"
    folder.mkdir(parents=True)
    for name in (MISSION_FILE, FAULTS_FILE):
        shutil.copy(metamodel_folder() / name, folder / name)
    monkeypatch.setenv("MRSFI_METAMODELS", str(folder))
    yield folder
    read_metamodels.cache_clear()
