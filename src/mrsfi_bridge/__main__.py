"""``python -m mrsfi_bridge``: the server alone."""

import sys

import click

from mrsfi_bridge.embedded import serve
from mrsfi_bridge.errors import BridgeError
from mrsfi_bridge.settings import bridge_command

_INTERRUPTED = 130
_PROGRAM = "python -m mrsfi_bridge"


def main() -> int:
    """Run the server and return the exit code."""
    try:
        bridge_command(_PROGRAM, serve).main(prog_name=_PROGRAM, standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except BridgeError as error:
        click.echo(f"mrsfi_bridge: {error}", err=True)
        return error.exit_code
    except (KeyboardInterrupt, click.Abort):
        click.echo("mrsfi_bridge: interrupted", err=True)
        return _INTERRUPTED
    return 0


if __name__ == "__main__":
    sys.exit(main())
