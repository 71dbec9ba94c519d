"""What the ID of a model element is called in Python, and in topics of ROS."""

import re

_SEPARATORS = re.compile(r"[_. -]+")


def plain_name(text: str) -> str:
    """Return an ID in lower case, runs of separators as one underscore.

    The IDs of a valid mission become different names, each ``[a-z][a-z0-9_]*``.

    Examples
    --------
    >>> plain_name("Scout-1")
    'scout_1'
    """
    return _SEPARATORS.sub("_", text).strip("_").lower()
