"""Names of topics, services and parameters."""

from mrsfi_bridge.errors import ProtocolError

_LONGEST = 256


def absolute(name: str) -> str:
    """Return a name from the root, with one slash before each part."""
    if name.startswith("/") and "//" not in name and not name.endswith("/"):
        return name
    return "/" + "/".join(part for part in name.split("/") if part)


def check_name(name: str, noun: str) -> None:
    """Refuse what is no name.

    Raises
    ------
    ProtocolError
        If the name is empty, too long, or has blanks or unprintable letters.
    """
    if name.strip("/") and len(name) <= _LONGEST and name.isprintable() and " " not in name:
        return
    shown = repr(name[:_LONGEST])
    raise ProtocolError(f"{shown} is no {noun} name: 1 to {_LONGEST} letters without blanks")
