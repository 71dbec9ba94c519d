"""Versions of what is installed."""


def installed_version(name: str) -> str:
    """Return the version of a distribution; mrsfi run from its source tree alone has none."""
    from importlib import metadata  # noqa: PLC0415 - takes half as long as `mrsfi --help`

    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
