"""The version of the world's rules, carried by records, by generated code and by the bus.

docs/semantics.md says what the rules are. The version changes when the same faults in the same
mission may lead to another flight; what carries another one is read, but never flown.

Version 1
    mrsfi 0.1. Verdicts and reactions are decided to the last bit; belief begins without a speed;
    a robot obeys commands up to five times its nominal speed.
Version 2
    mrsfi 0.3. Verdicts have a tolerance and reactions a reserve; belief begins with what the model
    says; a robot obeys commands up to its own greatest speed; an outcome says what was missed.
"""

SEMANTICS = 2
"""The version that this runtime flies."""


def difference(found: int) -> str:
    """Return the words of an error about a version that is not flown here."""
    return (
        f"found semantics {found}; expected semantics {SEMANTICS}, which this mrsfi flies "
        "(docs/semantics.md)"
    )
