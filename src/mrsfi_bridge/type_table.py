"""The message and service types that the server knows: those of folders, and of ``rosbags``.

A folder of definitions holds ``PACKAGE/msg/TYPE.msg`` and ``PACKAGE/srv/TYPE.srv``, as ROS
packages do. Types are named ``PACKAGE/TYPE`` or ``PACKAGE/msg/TYPE``.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from mrsfi_bridge.definitions import (
    SCALAR,
    TIMES,
    VARIABLE,
    Constant,
    Definition,
    Field,
    parse_message,
    parse_service,
)
from mrsfi_bridge.errors import ProtocolError, SettingsError
from mrsfi_bridge.structures import Structure

STANDARD = Path(__file__).parent / "types"
"""Definitions that come with the server: services, and messages that ``rosbags`` lacks."""

_NAME = re.compile(r"([A-Za-z]\w*)/(?:(?:msg|srv)/)?([A-Za-z]\w*)", re.ASCII)
_MAX_SHOWN = 80
_NO_FIELD = "structure_needs_at_least_one_member"
_BASES = {"octet": "byte"}
_TIMES = {f"builtin_interfaces/msg/{name.capitalize()}": name for name in TIMES}
"""How ``rosbags`` names what ROS 1 has as types of its own."""


class ServiceType(NamedTuple):
    """What a service takes and gives."""

    name: str
    request: Structure
    response: Structure


class TypeTable:
    """Types by name; a definition is read when its type is first asked for.

    Of the user's ``folders`` the first that has a type wins; those that come with the server, and
    the messages of ROS 1 Noetic, are the last resort. An unknown type is a ``ProtocolError``, a
    wrong definition a ``SettingsError``.
    """

    def __init__(self, folders: Sequence[Path] = ()) -> None:
        self._folders = (*folders, STANDARD)
        self._structures: dict[str, Structure] = {}
        self._services: dict[str, ServiceType] = {}
        self._open: list[str] = []

    def message(self, name: str) -> Structure:
        """Return the structure of a message type."""
        name = full_name(name)
        if name not in self._structures:
            self._structures[name] = self._read(name)
        return self._structures[name]

    def service(self, name: str) -> ServiceType:
        """Return request and response of a service type."""
        name = full_name(name)
        if name not in self._services:
            path = self._find(name, "srv")
            request, response = parse_service(name, _text(path), path)
            self._services[name] = ServiceType(
                name, Structure(request, self.message), Structure(response, self.message)
            )
        return self._services[name]

    def check(self) -> int:
        """Read every definition of the user's folders and return their number.

        A folder without definitions, or with a wrong one, is a ``SettingsError``.
        """
        n_read = 0
        for folder in self._folders[:-1]:
            names = tuple(_names(folder))
            if not names:
                raise SettingsError(
                    f"{folder}: no definitions; expected {folder}/PACKAGE/msg/TYPE.msg"
                )
            for kind, name in names:
                try:
                    _ = self.message(name) if kind == "msg" else self.service(name)
                except ProtocolError as error:
                    raise SettingsError(f"{folder}: {name}: {error}") from error
            n_read += len(names)
        return n_read

    def _read(self, name: str) -> Structure:
        if name in self._open:
            raise SettingsError(
                f"type {name} contains itself: {' in '.join((name, *reversed(self._open)))}"
            )
        path = self._path(name, "msg")
        known = _standard_message(name) if path is None else None
        self._open.append(name)
        try:
            if known is not None:
                return Structure(known, self.message)
            path = self._find(name, "msg")
            return Structure(parse_message(name, _text(path).splitlines(), path), self.message)
        finally:
            self._open.pop()

    def _path(self, name: str, kind: str) -> Path | None:
        package, _, type_name = name.partition("/")
        paths = (folder / package / kind / f"{type_name}.{kind}" for folder in self._folders)
        return next((path for path in paths if path.is_file()), None)

    def _find(self, name: str, kind: str) -> Path:
        path = self._path(name, kind)
        if path is not None:
            return path
        package, _, type_name = name.partition("/")
        noun = "message" if kind == "msg" else "service"
        file = f"{package}/{kind}/{type_name}.{kind}"
        raise ProtocolError(f"unknown {noun} type '{name}'; add {file} to a folder of --types")


def _standard_message(name: str) -> Definition | None:
    """Return a message of ROS 1 Noetic, if there is one of this name."""
    found = _noetic().get(name.replace("/", "/msg/"))
    if found is None:
        return None
    constants, fields = found
    return Definition(
        name,
        tuple(Field(field, *_typed(*node)) for field, node in fields if field != _NO_FIELD),
        tuple(Constant(constant, str(value)) for constant, _, value in constants),
    )


@cache
def _noetic() -> Mapping[str, Any]:
    return get_typestore(Stores.ROS1_NOETIC).fielddefs


def _typed(kind: Nodetype, found: Any) -> tuple[str, int]:
    """Return type and length of a field."""
    if kind in {Nodetype.ARRAY, Nodetype.SEQUENCE}:
        element, length = found
        return _typed(*element)[0], length if kind is Nodetype.ARRAY else VARIABLE
    if kind is Nodetype.BASE:
        return _BASES.get(found[0], found[0]), SCALAR
    return _TIMES.get(found, found.replace("/msg/", "/")), SCALAR


def full_name(name: str) -> str:
    """Return a type's name as ``PACKAGE/TYPE``; ``ProtocolError`` if the name is none of a type."""
    match = _NAME.fullmatch(name)
    if match is None:
        raise ProtocolError(f"'{name[:_MAX_SHOWN]}' is no type, expected 'package/Type'")
    return f"{match[1]}/{match[2]}"


def _names(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield kind and name of every definition in a folder."""
    for kind in ("msg", "srv"):
        for path in sorted(folder.glob(f"*/{kind}/*.{kind}")):
            yield kind, f"{path.parent.parent.name}/{path.stem}"


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"{path}: cannot be read: {error}") from error
