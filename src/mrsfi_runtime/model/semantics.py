"""The version of the world's rules, carried by records, by generated code and by the bus.

docs/semantics.md says what the rules are. The version changes when the same faults in the same
mission may lead to another flight; what carries another one is read, but never flown.

Version 1
    mrsfi 0.1. Verdicts and reactions are decided to the last bit; belief begins without a speed;
    a robot obeys commands up to five times its nominal speed.
Version 2
    mrsfi 0.2. Verdicts have a tolerance and reactions a reserve; belief begins with what the model
    says; a robot obeys commands up to its own greatest speed; an outcome says what was missed.
"""

from collections.abc import Mapping

SEMANTICS = 2
"""The version that this runtime flies."""

UNNUMBERED = 1
"""The version of what says none: there was no other when it was written."""

RELEASES: Mapping[int, str] = {1: "0.1", 2: "0.2"}
"""The releases of mrsfi that fly each version, by the beginning of their number."""


def flown_by(semantics: int, release: str = "") -> str:
    """Return which mrsfi flies a version, a later one included.

    ``release`` is the mrsfi known to have used one that stands in no table yet; may be empty.
    """
    known = RELEASES.get(semantics, release)
    return f"mrsfi {known}" if known else "a later mrsfi"


def difference(found: int) -> str:
    """Return the words of an error about a version that is not flown here."""
    return (
        f"found semantics {found}; expected semantics {SEMANTICS}, which this mrsfi flies "
        "(docs/semantics.md)"
    )
