"""Which web pages may connect: a browser tells the origin of the page that opens a socket."""

import re
from collections.abc import Sequence

from websockets.typing import Origin

_THIS_MACHINE = re.compile(r"https?://(?:localhost|127\.0\.0\.1|\[::1\])(?::\d+)?")


def accepted_origins(origins: Sequence[str]) -> list[Origin | re.Pattern[str] | None]:
    """Return the origins that may connect: programs, pages of this machine, and those named."""
    return [None, _THIS_MACHINE, *map(Origin, origins)]
