"""Validate models: every defect at once, none of them raised."""

from pathlib import Path

from m2t.diagnostics import Diagnostic
from m2t.load import inspect_folder, inspect_specification


def validate_folder(folder: Path) -> tuple[Diagnostic, ...]:
    """Return all that is wrong with the models of a mission folder, mission first.

    Parameters
    ----------
    folder
        The mission folder.

    Returns
    -------
    tuple of Diagnostic
        Errors and warnings; empty if the models are flawless.

    Notes
    -----
    Constraints of sense are checked on a file whose structure is sound: what they would say
    about missing parts helps nobody.
    """
    return inspect_folder(folder).diagnostics


def validate_specification(path: Path) -> tuple[Diagnostic, ...]:
    """Return all that is wrong with a fault specification and the mission that it refers to."""
    return inspect_specification(path).diagnostics
