"""The server's command line: options and settings.

``mrsfi bridge`` and ``python -m mrsfi_bridge`` are this command under two names.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from mrsfi_bridge.settings import Limits, ServerSettings
from mrsfi_bridge.type_table import TypeTable

_DEFAULT = Limits()
_MEBI = 1 << 20

_HELP = """Run a rosbridge server, for simulators and collective intelligences that meet on it.

It speaks the rosbridge v2 protocol of ROS 1 or ROS 2 and needs no ROS: roslibpy, roslib.js and
every other rosbridge client can connect. Its URL is printed to standard output, its log goes to
standard error. It runs until it is interrupted (exit code 130) or terminated (0).

\b
Examples:
  {program}
  {program} --port 0                    any free port; read it from standard output
  {program} --ros 2                     as rosbridge_suite on ROS 2 Jazzy answers
  {program} --types my_robots/          definitions in my_robots/PACKAGE/msg/TYPE.msg
  {program} --origin http://ui.example  a web page that may connect
  MRSFI_BRIDGE_TOKEN=… {program} --host 0.0.0.0 --public

It binds 127.0.0.1. Any other address needs --public and a token, which clients show in the
URL, ws://HOST:9090/?token=…, or as header `Authorization: Bearer …`. The connection is not
encrypted.
"""

_LIMITS = (
    ("--max-clients", "clients", 1, 10_000, "Clients at a time."),
    ("--max-frame", "frame_bytes", _MEBI, 1024, "Longest message in MiB."),
    ("--max-queue", "queue_bytes", _MEBI, 4096, "What may wait for a slow client, in MiB."),
    ("--max-memory", "total_bytes", _MEBI, 65536, "What may wait for all clients, in MiB."),
    ("--max-topics", "topics", 1, 1_000_000, "Topics at a time."),
)
"""Options, the limit that each sets, in which unit, the greatest value, and what it says."""

_OPTIONS = (
    click.option("--host", default="127.0.0.1", show_default=True, help="Address to bind."),
    click.option(
        "--port",
        type=click.IntRange(0, 65535),
        default=9090,
        show_default=True,
        help="Port to bind; 0 takes any free one.",
    ),
    click.option(
        "--ros",
        type=click.Choice(["1", "2"]),
        help="Version of ROS whose server it is like [default: the project's, or 1].",
    ),
    click.option("--public", "is_public", is_flag=True, help="Let other machines connect."),
    click.option(
        "--token",
        envvar="MRSFI_BRIDGE_TOKEN",
        help="What clients must show; also MRSFI_BRIDGE_TOKEN.",
    ),
    click.option(
        "--origin", "origins", multiple=True, help="Origin of web pages that may connect."
    ),
    click.option(
        "--types",
        "folders",
        multiple=True,
        type=click.Path(path_type=Path, exists=True, file_okay=False),
        help="Folder with message and service definitions of your own.",
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
        help="Seconds that a service has for its answer.",
    ),
)


def bridge_command(
    program: str, run: Callable[[ServerSettings], None], ros_unasked: Callable[[], int] = lambda: 1
) -> click.Command:
    """Return the command that has ``run`` run a server; the last word of ``program`` names it.

    ``ros_unasked`` says of which version of ROS it is, unless the command line does.
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
