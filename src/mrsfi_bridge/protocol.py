"""From texts to operations: JSON, the fields of every operation, names, fragments.

References
----------
https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md
"""

import json
from collections.abc import Callable, Iterator
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.frames import from_json

Operation: TypeAlias = dict[str, Any]

_MAX_SHOWN = 100
_LONGEST_ID = 256
_LONGEST_NAME = 256  # of a topic, a service or a parameter
_MAX_FRAGMENTS = 100_000
_FRAGMENT_BYTES = 64
"""What a fragment takes beside its letters."""

_MAX_UNFINISHED = 16

_DECODER = json.JSONDecoder()


class _Field(NamedTuple):
    """A field of an operation."""

    kinds: tuple[type, ...]
    is_required: bool = False


_TEXT = _Field((str,))
_NAME = _Field((str,), is_required=True)
_SOME = _Field((int, type(None)))
_ID = _Field((str, int, type(None)))
_CALL = _Field((str, int), is_required=True)

_FIELDS = MappingProxyType(
    {
        "advertise": {"topic": _NAME, "type": _NAME, "latch": _Field((bool,)), "id": _ID},
        "unadvertise": {"topic": _NAME, "id": _ID},
        "publish": {"topic": _NAME, "msg": _Field((dict,)), "latch": _Field((bool,)), "id": _ID},
        "subscribe": {
            "topic": _NAME,
            "type": _Field((str, type(None))),
            "throttle_rate": _Field((int, float)),
            "queue_length": _Field((int,)),
            "fragment_size": _SOME,
            "compression": _TEXT,
            "id": _ID,
        },
        "unsubscribe": {"topic": _NAME, "id": _ID},
        "call_service": {
            "service": _NAME,
            "args": _Field((dict, list, type(None))),
            "timeout": _Field((int, float, type(None))),
            "fragment_size": _SOME,
            "compression": _TEXT,
            "id": _ID,
        },
        "service_response": {
            "service": _NAME,
            "id": _CALL,
            "result": _Field((bool, type(None))),
        },
        "advertise_service": {"service": _NAME, "type": _NAME, "id": _ID},
        "unadvertise_service": {"service": _NAME, "id": _ID},
        "advertise_action": {"action": _NAME, "type": _NAME, "id": _ID},
        "unadvertise_action": {"action": _NAME, "id": _ID},
        "send_action_goal": {
            "action": _NAME,
            "action_type": _NAME,
            "args": _Field((dict, list, type(None))),
            "feedback": _Field((bool,)),
            "fragment_size": _SOME,
            "compression": _TEXT,
            "id": _ID,
        },
        "cancel_action_goal": {"action": _NAME, "id": _CALL},
        "action_feedback": {"action": _NAME, "id": _CALL},
        "action_result": {
            "action": _NAME,
            "id": _CALL,
            "status": _Field((int,)),
            "result": _Field((bool,)),
        },
        "set_level": {"level": _NAME, "id": _ID},
        "fragment": {
            "id": _CALL,
            "data": _NAME,
            "num": _Field((int,), is_required=True),
            "total": _Field((int,), is_required=True),
        },
    }
)
"""Fields that an operation may have; others are ignored, as the genuine server does."""


def operations(text: str, refuse: Callable[[str], None]) -> Iterator[Any]:
    """Yield the JSON values of a frame, which may hold several.

    ``refuse`` is told once if a part of the text is no JSON.
    """
    try:
        value = from_json(text)
    except (ValueError, RecursionError):
        yield from _several(text, refuse)
    else:
        yield value


def _several(text: str, refuse: Callable[[str], None]) -> Iterator[Any]:
    """Yield the values that follow each other in a text."""
    position = 0
    while position < len(text):
        try:
            value, position = _DECODER.raw_decode(text, position)
        except (ValueError, RecursionError) as error:
            reason = str(error) if isinstance(error, ValueError) else "nested too deeply"
            refuse(f"bad JSON at letter {position + 1} of {len(text)}: {reason:.{_MAX_SHOWN}}")
            return
        yield value
        while position < len(text) and text[position] in " \t\r\n":
            position += 1


def check_operation(value: Any) -> Operation:
    """Return an operation whose fields are of the right kind; ``ProtocolError`` if one is not."""
    if not isinstance(value, dict):
        raise ProtocolError(f"found {value!r:.{_MAX_SHOWN}}, expected an object with 'op'")
    op = value.get("op")
    fields = _FIELDS.get(op) if isinstance(op, str) else None
    if fields is None:
        known = ", ".join(_FIELDS)
        raise ProtocolError(f"unknown op {op!r:.{_MAX_SHOWN}}, expected one of {known}")
    for name, field in fields.items():
        if name not in value:
            if field.is_required:
                raise ProtocolError(f"{op}: field '{name}' is missing")
        elif type(value[name]) not in field.kinds:
            kinds = " or ".join(kind.__name__ for kind in field.kinds)
            raise ProtocolError(
                f"{op}: '{name}' is {value[name]!r:.{_MAX_SHOWN}}, expected {kinds}"
            )
    if len(str(value.get("id", ""))) > _LONGEST_ID:
        raise ProtocolError(f"{op}: 'id' is longer than {_LONGEST_ID} letters")
    return value


def absolute(name: str) -> str:
    """Return a name from the root, with one slash before each part."""
    if name.startswith("/") and "//" not in name and not name.endswith("/"):
        return name
    return "/" + "/".join(part for part in name.split("/") if part)


def check_name(name: str, noun: str) -> None:
    """Raise ``ProtocolError`` at a name empty, too long, or with blanks or unprintable letters."""
    if name.strip("/") and len(name) <= _LONGEST_NAME and name.isprintable() and " " not in name:
        return
    shown = repr(name[:_LONGEST_NAME])
    raise ProtocolError(f"{shown} is no {noun} name: 1 to {_LONGEST_NAME} letters without blanks")


class _Unfinished(NamedTuple):
    """A message of which some fragments are still to come."""

    total: int
    parts: list[str]
    n_bytes: int


class Fragments:
    """Puts messages together that arrive in fragments; unfinished ones share ``max_bytes``.

    The fragments of a message arrive in order. After one that is refused, the others of its
    message are refused, too, since the next one to be taken is again the first of a message.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._unfinished: dict[str | int, _Unfinished] = {}
        self.n_bytes = 0

    def add(self, fragment: Operation) -> str | None:
        """Take a fragment; return the message that it completes.

        It is a ``ProtocolError`` if the fragment makes no sense, or unfinished messages take too
        much.
        """
        fragment_id, number, total = fragment["id"], fragment["num"], fragment["total"]
        message = self._forget(fragment_id) or _Unfinished(total, [], 0)
        if not 0 <= number < total <= _MAX_FRAGMENTS:
            raise ProtocolError(f"fragment {number} of {total}, of at most {_MAX_FRAGMENTS}")
        if (number, total) != (len(message.parts), message.total):
            expected = f"{len(message.parts)} of {message.total}"
            raise ProtocolError(f"fragment {number} of {total}, expected {expected}")
        if len(self._unfinished) >= _MAX_UNFINISHED:
            raise ProtocolError(
                f"{_MAX_UNFINISHED} messages in fragments are unfinished, the limit"
            )
        n_bytes = message.n_bytes + len(fragment["data"]) + _FRAGMENT_BYTES
        if self.n_bytes + n_bytes > self._max_bytes:
            raise ProtocolError(f"unfinished messages take over {self._max_bytes} bytes, the limit")
        message.parts.append(fragment["data"])
        if len(message.parts) == total:
            return "".join(message.parts)
        self._unfinished[fragment_id] = message._replace(n_bytes=n_bytes)
        self.n_bytes += n_bytes
        return None

    def _forget(self, fragment_id: str | int) -> _Unfinished | None:
        """Return what has arrived of a message, and keep it no more."""
        message = self._unfinished.pop(fragment_id, None)
        self.n_bytes -= 0 if message is None else message.n_bytes
        return message
