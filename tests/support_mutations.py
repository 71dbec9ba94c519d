"""Random mutations of a mission folder that keep its structure in XML."""

import random
import re
from collections.abc import Callable
from pathlib import Path

from support_model import FAULTS, MISSION

_NUMBERS = ("-1", "0", "1", "7", "1000", "2147483647")
_DOUBLES = (*_NUMBERS, "2.5", "-0.5", "1e13", "NaN", "-Infinity", "1.0E-5", "500.0")
_TEXTS = ("", "SPEED", "ENERGY", "Int", "1x", "class", "a b", "R1", "it's", "x" * 61, "x" * 2001)
_INTEGERS = (
    "duration",
    "samplesPerSecond",
    "targetSampleNumber",
    "start",
    "finish",
    "VAL",
)
_ATTRIBUTE = re.compile(r' ([A-Za-z_]+)="([^"]*)"')
_LINE = re.compile(r"^ +<.*/>\n", re.MULTILINE)


def mutated(folder: Path, rng: random.Random) -> None:
    """Change one to four places of the models of a folder."""
    for _ in range(rng.randint(1, 4)):
        path = folder / rng.choice((MISSION, MISSION, FAULTS))
        text = path.read_text(encoding="utf-8")
        path.write_text(rng.choice(_CHANGES)(text, rng), encoding="utf-8")


def _change_value(text: str, rng: random.Random) -> str:
    match = rng.choice([found for found in _ATTRIBUTE.finditer(text) if found.start() > 200])
    name, value = match.groups()
    return _spliced(text, match.span(2), rng.choice(_values(name, value, text)))


def _values(name: str, value: str, text: str) -> tuple[str, ...]:
    if name in _INTEGERS:
        return _NUMBERS
    if re.fullmatch(r"[-+.\dEe]*\d[-+.\dEe]*", value):
        return _DOUBLES if "." in value else _NUMBERS
    if name in ("members", "robots", "obstacles", "sender", "receiver", "sensor"):
        kind = value.rstrip("0123456789 ")[:1]
        same = re.findall(rf' ID="({kind}\d+)"', text)
        return tuple(same) or (value,)
    return (value,) if name == "href" else (*_TEXTS, value.upper(), f"{value}-")


def _delete_attribute(text: str, rng: random.Random) -> str:
    match = rng.choice([found for found in _ATTRIBUTE.finditer(text) if found.start() > 200])
    return _spliced(text, match.span(), "")


def _delete_line(text: str, rng: random.Random) -> str:
    return _spliced(text, rng.choice(list(_LINE.finditer(text))).span(), "")


def _double_line(text: str, rng: random.Random) -> str:
    match = rng.choice(list(_LINE.finditer(text)))
    return _spliced(text, (match.end(), match.end()), match[0])


def _give_window(text: str, rng: random.Random) -> str:
    window = rng.choice((' start="3"', ' finish="-3"', ' start="9" finish="8"', ' start="1000"'))
    return _spliced_after(text, r"<faults ID=\"\w+\"", window, rng)


def _give_search_bounds(text: str, rng: random.Random) -> str:
    bounds = rng.choice(('_MIN="9.5" {}_MAX="3"', '_MIN="-3" {}_MAX="-7"', '_MIN="1"'))
    pattern = r" (DELAY|BLOCK_DURATION|PERCENTAGE|NEW_X)="
    matches = list(re.finditer(pattern, text))
    if not matches:
        return text
    match = rng.choice(matches)
    name = match[1]
    return _spliced(text, (match.start(), match.start()), f" {name}{bounds.format(name)}")


def _give_tasks(text: str, rng: random.Random) -> str:
    task = rng.choice(
        (
            '<task xsi:type="mission:Visit" deadline="1000"><coordinates/></task>',
            '<task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="9.0"/>',
            '<task xsi:type="mission:Patrol" period="0"><area ID="pa" radius="3000.0"/></task>',
            '<task xsi:type="mission:Stay"><area ID="r1" radius="1.0"/></task>',
        )
    )
    matches = list(re.finditer(r"<task [^>]*/>", text))
    return _spliced(text, rng.choice(matches).span(), task) if matches else text


def _give_dependence(text: str, rng: random.Random) -> str:
    return _spliced_after(text, r"<goals ID=\"\w+\"", ' dependentGoals="g1 g2"', rng)


def _give_property(text: str, rng: random.Random) -> str:
    lines = (
        '    <intProperties name="hull" value="1"/>\n',
        '    <stringProperties name="hull" value=""/>\n    <doubleProperties name="hull"/>\n',
        '    <doubleProperties name="hull" value="1"/>\n' * 2,
    )
    matches = list(re.finditer(r"^    <position", text, re.MULTILINE))
    if not matches:
        return text
    start = rng.choice(matches).start()
    return _spliced(text, (start, start), rng.choice(lines))


def _lose_target(text: str, rng: random.Random) -> str:
    return _spliced_after(text, r"mission.xmi#\w+", "9", rng)


def _move_robot(text: str, rng: random.Random) -> str:
    matches = list(re.finditer(r"<position [^>]*/>", text))
    if not matches:
        return text
    x, y = rng.choice((("500.0", "30.0"), ("250.0", "251.0"), ("1200.0", "1600.0"), ("9e3", "0")))
    return _spliced(text, rng.choice(matches).span(), f'<position x="{x}" y="{y}"/>')


def _spliced_after(text: str, pattern: str, added: str, rng: random.Random) -> str:
    matches = list(re.finditer(pattern, text))
    if not matches:
        return text
    end = rng.choice(matches).end()
    return _spliced(text, (end, end), added)


def _spliced(text: str, span: tuple[int, int], new: str) -> str:
    return text[: span[0]] + new + text[span[1] :]


_CHANGES: tuple[Callable[[str, random.Random], str], ...] = (
    _change_value,
    _change_value,
    _delete_attribute,
    _delete_line,
    _double_line,
    _give_window,
    _give_search_bounds,
    _give_tasks,
    _give_dependence,
    _give_property,
    _lose_target,
    _move_robot,
)
