"""What a broken model is to a test: an edit, and the diagnostic that it has to cause."""

from typing import NamedTuple


class Broken(NamedTuple):
    """An edit of a flawless model, and the diagnostic that it has to cause.

    ``place`` is a fragment of the line that has to be named, after the edit.
    """

    constraint: str
    file: str
    old: str
    new: str
    place: str
    element: str
    message: str
