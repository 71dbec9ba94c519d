"""The command ``mrsfi bridge``: the command of ``mrsfi_bridge`` with the errors of ``mrsfi``."""

from mrsfi_bridge.errors import BridgeError
from mrsfi_bridge.settings import ServerSettings, bridge_command


def _serve(settings: ServerSettings) -> None:
    from mrsfi_bridge.embedded import serve

    try:
        serve(settings)
    except BridgeError as error:
        from mrsfi_runtime.transport.rosbridge import as_ours

        raise as_ours(error) from error


def _ros_of_project() -> int:
    from mrsfi.engines import project

    return project().ros


command = bridge_command("mrsfi bridge", _serve, _ros_of_project)
