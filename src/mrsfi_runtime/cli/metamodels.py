"""Which metamodels are read, if they are a team's own."""

from mrsfi.models import own_metamodels
from mrsfi_runtime.cli.console import tell


def tell_of_metamodels() -> None:
    """Tell where the metamodels are, unless they are those of mrsfi."""
    folder = own_metamodels()
    if folder is not None:
        tell(f"metamodels {folder}, which are not those of mrsfi")
