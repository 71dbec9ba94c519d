"""Settings of a server: types, address, limits, and the options that set them.

A ``TypeTable`` has the types of messages, services and actions by name. It reads those of the
user's folders first, then those that come with the server, then those of ROS in ``rosbags``. A
folder of definitions holds ``PACKAGE/msg/TYPE.msg``, ``PACKAGE/srv/TYPE.srv`` and
``PACKAGE/action/TYPE.action``, as ROS packages do. Clients may name a type ``PACKAGE/TYPE`` or
``PACKAGE/msg/TYPE``; this package uses the first form.

``ServerSettings`` has the address and the permitted clients, ``Limits`` the limits of a client.
``bridge_command`` makes the command line: ``mrsfi bridge`` and ``python -m mrsfi_bridge`` are
this command under two names.

Settings are values: nothing here opens a file or a socket until a type is asked for by name.
This module imports no websocket, so that ``mrsfi bridge --help`` starts quickly.
"""

import ipaddress
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import click
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from mrsfi_bridge.errors import ProtocolError, SettingsError
from mrsfi_bridge.structures import TIMES, Definition, Structure, parse_message, parse_parts

STANDARD = Path(__file__).parent / "types"
"""Definitions that come with the server: services, and messages that ``rosbags`` lacks."""

_NAME = re.compile(r"([A-Za-z]\w*)/(?:(?:msg|srv|action)/)?([A-Za-z]\w*)", re.ASCII)
_MAX_SHOWN = 80
_MESSAGES = {name: f"builtin_interfaces/{name.capitalize()}" for name in TIMES}
"""Messages in ROS 2 and in ``rosbags`` that are primitive types in ROS 1."""

_PACKAGES = {"rosapi_msgs": "rosapi", "example_interfaces": "rospy_tutorials"}
"""Packages of ROS 2 whose definitions belong to another package in ROS 1."""

_NOUNS = {"msg": "message", "srv": "service", "action": "action"}


class ServiceType(NamedTuple):
    """Request and response of a service, or of an action, which also has ``feedback``."""

    name: str
    request: Structure
    response: Structure
    feedback: Structure | None = None


class TypeTable:
    """Types by name; a definition is read when its type is first asked for.

    The first of the user's ``folders`` that has a type wins, then the definitions of the server,
    then the messages of Noetic or Jazzy (``ros`` 1 or 2). An unknown type is a
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
        return name if self.ros == 1 else name.replace("/", f"/{kind}/")

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
        has_own = self._path(name, "msg") is not None
        found = None if has_own else _standard_message(name, self.ros)
        if found is None:
            path = self._find(name, "msg")
            found = parse_message(name, _text(path).splitlines(), path, self.ros)
        self._open.append(name)
        try:
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
    """Return a standard message of ROS, if there is one of this name."""
    known, full = _known(ros), name.replace("/", "/msg/")
    if full not in known.fielddefs:
        return None
    text, _ = known.generate_msgdef(full, ros_version=ros)
    own, *_ = text.split("=" * 80)  # the definitions of its parts follow
    if ros != 1 and name == "geometry_msgs/Quaternion":
        own = own.replace("float64 w", "float64 w 1.0")  # rosbags has no defaults
    return parse_message(name, own.splitlines(), Path(full), ros)


@cache
def _known(ros: int) -> Typestore:
    return get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_JAZZY)


def full_name(name: str) -> str:
    """Return a type's name as ``PACKAGE/TYPE``; an invalid one is a ``ProtocolError``."""
    match = _NAME.fullmatch(name)
    if match is None:
        raise ProtocolError(f"'{name[:_MAX_SHOWN]}' is not a type name; expected 'package/Type'")
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


_MEBI = 1 << 20


@dataclass(frozen=True, slots=True)
class Limits:
    """How much of the server's memory and time clients may use."""

    clients: int = 256  # connections at a time
    frame_bytes: int = 10 * _MEBI  # longest message of a client, also in fragments
    queue_bytes: int = 24 * _MEBI  # data queued for one client that reads too slowly
    total_bytes: int = 256 * _MEBI  # data held for and from all clients together
    latched_bytes: int = 64 * _MEBI  # last messages of all latched topics together
    topics: int = 20_000  # at a time, as services and parameters
    services: int = 5_000
    calls: int = 20_000  # open calls of a client at a time, and as many goals
    parameters: int = 10_000
    parameter_bytes: int = 1 << 16  # longest parameter, as JSON text
    handshake_s: float = 10.0  # time for the opening handshake
    ping_s: float = 15.0  # silence after which a client is pinged
    pong_s: float = 30.0  # further silence after which it is cut off
    close_s: float = 3.0  # time for a closing handshake
    service_s: float = 30.0  # time within which a provider must answer


@dataclass(frozen=True, slots=True)
class ServerSettings:
    """Address of a server, its permitted clients and their limits."""

    host: str = "127.0.0.1"
    port: int = 0  # any free one
    is_public: bool = False  # whether ``host`` may be one that other machines reach
    token: str | None = field(default=None, repr=False)  # clients of a public server send it
    origins: tuple[str, ...] = ()  # of web pages that may connect, beside those of this machine
    types: TypeTable = field(default_factory=TypeTable)
    limits: Limits = Limits()

    def check(self) -> None:
        """Refuse, as a ``SettingsError``, settings that would open the server to strangers."""
        if not is_loopback(self.host):
            if not self.is_public:
                raise SettingsError(
                    f"{self.host} can be reached from other machines: "
                    "add --public and --token, or bind 127.0.0.1"
                )
            if self.token is None:
                raise SettingsError(
                    "a public server needs a token that its clients must send: add --token"
                )
        if self.token is not None and not re.fullmatch(r"[\w-]{16,}", self.token, re.ASCII):
            raise SettingsError("a token needs at least 16 letters, digits, '-' or '_'")


def is_loopback(host: str) -> bool:
    """Return whether only this machine reaches an address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


_DEFAULT = Limits()

_HELP = """Run a rosbridge server to which simulators and collective intelligences connect.

It speaks the rosbridge v2 protocol of ROS 1 or ROS 2 and needs no ROS: roslibpy, roslib.js and
every other rosbridge client can connect. It prints its URL to standard output and its log to
standard error. It runs until it is interrupted (exit code 130) or terminated (0).

\b
Examples:
  {program}
  {program} --port 0                    any free port; read it from standard output
  {program} --ros 2                     answer as rosbridge_suite on ROS 2 Jazzy does
  {program} --types my_robots/          definitions in my_robots/PACKAGE/msg/TYPE.msg
  {program} --origin http://ui.example  let a web page connect
  MRSFI_BRIDGE_TOKEN=… {program} --host 0.0.0.0 --public

It binds 127.0.0.1. Any other address needs --public and a token, which clients send in the
URL, ws://HOST:9090/?token=…, or in the header `Authorization: Bearer …`. The connection is
not encrypted.
"""

_LIMITS = (
    ("--max-clients", "clients", 1, 10_000, "Clients that may be connected at a time."),
    ("--max-frame", "frame_bytes", _MEBI, 1024, "Longest message in MiB."),
    ("--max-queue", "queue_bytes", _MEBI, 4096, "Data queued for one slow client, in MiB."),
    ("--max-memory", "total_bytes", _MEBI, 65536, "Data queued for all clients, in MiB."),
    ("--max-topics", "topics", 1, 1_000_000, "Topics that may exist at a time."),
)
"""Options: the limit that each sets, its unit, greatest value and help text."""

_OPTIONS = (
    click.option("--host", default="127.0.0.1", show_default=True, help="Address to bind."),
    click.option(
        "--port",
        type=click.IntRange(0, 65535),
        default=9090,
        show_default=True,
        help="Port to bind; 0 selects any free port.",
    ),
    click.option(
        "--ros",
        type=click.Choice(["1", "2"]),
        help="Version of ROS that it emulates [default: the project's, or 1].",
    ),
    click.option("--public", "is_public", is_flag=True, help="Let other machines connect."),
    click.option(
        "--token",
        envvar="MRSFI_BRIDGE_TOKEN",
        help="Token that clients must send; also read from MRSFI_BRIDGE_TOKEN.",
    ),
    click.option("--origin", "origins", multiple=True, help="Origin whose web pages may connect."),
    click.option(
        "--types",
        "folders",
        multiple=True,
        type=click.Path(path_type=Path, exists=True, file_okay=False),
        help="Folder with your definitions of messages, services and actions.",
    ),
    *(
        click.option(
            option,
            limit,
            type=click.IntRange(1, most),
            default=getattr(_DEFAULT, limit) // unit,
            show_default=True,
            help=text,
        )
        for option, limit, unit, most, text in _LIMITS
    ),
    click.option(
        "--service-timeout",
        "service_s",
        type=click.FloatRange(0, min_open=True),
        default=_DEFAULT.service_s,
        show_default=True,
        help="Seconds within which a service must answer.",
    ),
)


def bridge_command(
    program: str, run: Callable[[ServerSettings], None], ros_unasked: Callable[[], int] = lambda: 1
) -> click.Command:
    """Return the command that calls ``run`` with settings; its name is the end of ``program``.

    ``ros_unasked`` returns the version of ROS if the command line gives none.
    """

    def callback(
        ros: str | None, folders: tuple[Path, ...], service_s: float, **given: Any
    ) -> None:
        limits = {limit: given.pop(limit) * unit for _, limit, unit, _, _ in _LIMITS}
        types = TypeTable(folders, int(ros or ros_unasked()))
        run(ServerSettings(**given, types=types, limits=Limits(**limits, service_s=service_s)))

    for option in reversed(_OPTIONS):
        callback = option(callback)
    name = program.rpartition(" ")[2]
    return click.command(
        name=name,
        help=_HELP.format(program=program),
        context_settings={"help_option_names": ["-h", "--help"]},
    )(callback)
