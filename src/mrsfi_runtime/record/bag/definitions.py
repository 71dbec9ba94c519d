"""Definitions of ROS 2 messages, as a bag has them beside the messages.

References
----------
https://mcap.dev/spec/registry, schema encoding ``ros2msg``.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files

_RULE = "=" * 80


def definition(name: str) -> str:
    """Return the definition of a message, ``std_msgs/Bool``, and after it those of all in it."""
    nested = list(dict.fromkeys(_nested(name)))
    parts = [_definitions()[name], *(f"MSG: {each}\n{_definitions()[each]}" for each in nested)]
    return f"{_RULE}\n".join(parts)


def _nested(name: str) -> Iterator[str]:
    for line in _definitions()[name].splitlines():
        kind = line.split()[0].removesuffix("[]")
        if "/" in kind:
            yield kind
            yield from _nested(kind)


@cache
def _definitions() -> Mapping[str, str]:
    text = files(__package__).joinpath("interfaces.msg").read_text(encoding="utf-8")
    _, *parts = text.split(f"{_RULE}\nMSG: ")
    return {name: fields for name, _, fields in (part.partition("\n") for part in parts)}
