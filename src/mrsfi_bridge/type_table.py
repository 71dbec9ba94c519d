"""The message and service types that the server knows: those of folders, and of ``rosbags``.

A folder of definitions holds ``PACKAGE/msg/TYPE.msg``, ``PACKAGE/srv/TYPE.srv`` and
``PACKAGE/action/TYPE.action``, as ROS packages do. Types are named ``PACKAGE/TYPE`` or
``PACKAGE/msg/TYPE``, here always in the first way.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from mrsfi_bridge.errors import ProtocolError, SettingsError
from mrsfi_bridge.structures import (
    SCALAR,
    TIMES,
    VARIABLE,
    Constant,
    Definition,
    Field,
    Structure,
    parse_message,
    parse_parts,
)

STANDARD = Path(__file__).parent / "types"
"""Definitions that come with the server: services, and messages that ``rosbags`` lacks."""

_NAME = re.compile(r"([A-Za-z]\w*)/(?:(?:msg|srv|action)/)?([A-Za-z]\w*)", re.ASCII)
_MAX_SHOWN = 80
_NO_FIELD = "structure_needs_at_least_one_member"
_BASES = {"octet": "byte"}
_MESSAGES = {name: f"builtin_interfaces/{name.capitalize()}" for name in TIMES}
"""What is a message in ROS 2, and in ``rosbags``, and a type of its own in ROS 1."""

_TIMES = {message: name for name, message in _MESSAGES.items()}
_PACKAGES = {"rosapi_msgs": "rosapi", "example_interfaces": "rospy_tutorials"}
"""Packages of ROS 2 whose definitions are those of another one in ROS 1."""

_QUATERNION = "geometry_msgs/Quaternion"
_NOUNS = {"msg": "message", "srv": "service", "action": "action"}


class ServiceType(NamedTuple):
    """What a service takes and gives; or an action, which gives ``feedback``, too."""

    name: str
    request: Structure
    response: Structure
    feedback: Structure | None = None


class TypeTable:
    """Types by name; a definition is read when its type is first asked for.

    Of the user's ``folders`` the first that has a type wins; those that come with the server, and
    the messages of Noetic or Jazzy, as ``ros`` is 1 or 2, are the last resort. An unknown type is a
    ``ProtocolError``, a wrong definition a ``SettingsError``.
    """

    def __init__(self, folders: Sequence[Path] = (), ros: int = 1) -> None:
        self.ros = ros
        self._folders = (*folders, STANDARD)
        self._structures: dict[str, Structure] = {}
        self._services: dict[tuple[str, str], ServiceType] = {}
        self._open: list[str] = []

    def message(self, name: str) -> Structure:
        """Return the structure of a message type."""
        name = full_name(name)
        if name not in self._structures:
            self._structures[name] = self._read(name)
        return self._structures[name]

    def service(self, name: str) -> ServiceType:
        """Return request and response of a service type."""
        return self._exchange(name, "srv", ("Request", "Response"))

    def action(self, name: str) -> ServiceType:
        """Return goal, result and feedback of an action type."""
        return self._exchange(name, "action", ("Goal", "Result", "Feedback"))

    def spelled(self, name: str, kind: str = "msg") -> str:
        """Return the name of a type as ROS spells it: ROS 2 in three parts."""
        if self.ros == 1:
            return name
        return name.replace("/", f"/{kind}/")

    def check(self) -> int:
        """Read every definition of the user's folders and return their number.

        A folder without definitions, or with a wrong one, is a ``SettingsError``.
        """
        n_read = 0
        read = {"msg": self.message, "srv": self.service, "action": self.action}
        for folder in self._folders[:-1]:
            names = tuple(_names(folder))
            if not names:
                raise SettingsError(
                    f"{folder}: no definitions; expected {folder}/PACKAGE/msg/TYPE.msg"
                )
            for kind, name in names:
                try:
                    read[kind](name)
                except ProtocolError as error:
                    raise SettingsError(f"{folder}: {name}: {error}") from error
            n_read += len(names)
        return n_read

    def _exchange(self, name: str, kind: str, parts: Sequence[str]) -> ServiceType:
        name = full_name(name)
        if (name, kind) not in self._services:
            path = self._find(name, kind)
            definitions = parse_parts(name, parts, _text(path), path, self.ros)
            structures = (self._structure(each) for each in definitions)
            self._services[name, kind] = ServiceType(name, *structures)
        return self._services[name, kind]

    def _structure(self, definition: Definition) -> Structure:
        if self.ros != 1:
            fields = definition.fields
            in_ros_2 = (replace(f, type=_MESSAGES.get(f.type, f.type)) for f in fields)
            definition = replace(definition, fields=tuple(in_ros_2))
        return Structure(definition, self.message, self.ros)

    def _read(self, name: str) -> Structure:
        if name in self._open:
            raise SettingsError(
                f"type {name} contains itself: {' in '.join((name, *reversed(self._open)))}"
            )
        path = self._path(name, "msg")
        known = _standard_message(name, self.ros) if path is None else None
        self._open.append(name)
        try:
            if known is not None:
                return self._structure(known)
            path = self._find(name, "msg")
            found = parse_message(name, _text(path).splitlines(), path, self.ros)
            return self._structure(found)
        finally:
            self._open.pop()

    def _path(self, name: str, kind: str) -> Path | None:
        package, _, type_name = name.partition("/")
        paths = [folder / package / kind / f"{type_name}.{kind}" for folder in self._folders]
        if self.ros != 1 and package in _PACKAGES:
            paths.append(STANDARD / _PACKAGES[package] / kind / f"{type_name}.{kind}")
        return next((path for path in paths if path.is_file()), None)

    def _find(self, name: str, kind: str) -> Path:
        path = self._path(name, kind)
        if path is not None:
            return path
        package, _, type_name = name.partition("/")
        file = f"{package}/{kind}/{type_name}.{kind}"
        raise ProtocolError(
            f"unknown {_NOUNS[kind]} type '{name}'; add {file} to a folder of --types"
        )


def _standard_message(name: str, ros: int) -> Definition | None:
    """Return a message of ROS itself, if there is one of this name."""
    found = _messages(ros).get(name.replace("/", "/msg/"))
    if found is None:
        return None
    constants, fields = found
    return Definition(
        name,
        tuple(_field(name, ros, field, *node) for field, node in fields if field != _NO_FIELD),
        tuple(Constant(constant, str(value)) for constant, _, value in constants),
    )


@cache
def _messages(ros: int) -> Mapping[str, Any]:
    return get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_JAZZY).fielddefs


def _field(message: str, ros: int, name: str, kind: Nodetype, found: Any) -> Field:
    if kind in {Nodetype.ARRAY, Nodetype.SEQUENCE}:
        element, length = found
        type_name = _field(message, ros, name, *element).type
        is_fixed = kind is Nodetype.ARRAY
        return Field(name, type_name, *((length,) if is_fixed else (VARIABLE, length)))
    if kind is Nodetype.BASE:
        is_unit = ros != 1 and (message, name) == (_QUATERNION, "w")  # rosbags has no defaults
        type_name, bound = found
        default = 1.0 if is_unit else None
        return Field(name, _BASES.get(type_name, type_name), SCALAR, bound, default)
    short = found.replace("/msg/", "/")
    return Field(name, _TIMES.get(short, short) if ros == 1 else short)


def full_name(name: str) -> str:
    """Return a type's name as ``PACKAGE/TYPE``; ``ProtocolError`` if the name is none of a type."""
    match = _NAME.fullmatch(name)
    if match is None:
        raise ProtocolError(f"'{name[:_MAX_SHOWN]}' is no type, expected 'package/Type'")
    return f"{match[1]}/{match[2]}"


def _names(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield kind and name of every definition in a folder."""
    for kind in _NOUNS:
        for path in sorted(folder.glob(f"*/{kind}/*.{kind}")):
            yield kind, f"{path.parent.parent.name}/{path.stem}"


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"{path}: cannot be read: {error}") from error
