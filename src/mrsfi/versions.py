"""Versions of what is installed."""


def installed_version(name: str) -> str:
    """Return the version of a distribution, or of python; mrsfi run from its source has none."""
    import platform  # noqa: PLC0415 - as below
    from importlib import metadata  # noqa: PLC0415 - takes half as long as `mrsfi --help`

    if name == "python":
        return platform.python_version()
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
