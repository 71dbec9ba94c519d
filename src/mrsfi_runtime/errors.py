"""Every error that a user can meet, and the exit code it ends a command with.

::

    MrsfiError                  1  a defect of ours
    ├── UsageError              2  a setting or an argument that makes no sense
    ├── ModelError              3  a metamodel or model that cannot be used
    ├── GenerationError         4  generation impossible, or generated code stale
    │   └── ProtectedRegionError   hand-written code in danger
    ├── SpecificationError      5  a fault specification that cannot be flown
    ├── EvaluationError         6  the mission's own code failed
    │   └── WorkerLost             or ended its process
    ├── ReplayMismatch          7  a replay differs from its record
    ├── TransportError          8  messages were lost
    │   ├── TransportTimeout
    │   ├── TransportClosed
    │   └── ProtocolError
    ├── RecordError             9  a campaign folder that cannot be read, written or flown
    ├── LimitExceeded          10  a kept weakness exceeds its limit
    └── UndecidedWeakness      11  a weakness is neither kept nor decided on

Programming mistakes stay ``TypeError`` and ``ValueError``. A ``Diagnostic`` is one of several
defects that are found together.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import ClassVar, Literal, NamedTuple, TypeAlias

LIMITED = "this machine limits memory or processes (`ulimit -v`, `ulimit -u`); allow more"
"""Message if the machine gives no more memory or threads."""


Severity: TypeAlias = Literal["error", "warning"]


class Diagnostic(NamedTuple):
    """A defect of a model or of a region; with an error it must not fly, with a warning it may.

    ``line`` counts from 1, ``element`` is like ``robots 'r1'`` or ``region 'g1.check'``,
    ``constraint`` the name of the rule; ``message`` gives the element, the finding, the
    expectation, and the next step.
    """

    path: Path
    line: int
    element: str
    constraint: str
    severity: Severity
    message: str

    @property
    def words(self) -> str:
        """Its place and its message."""
        return f"{self.path}:{self.line}: {self.message}"

    def __str__(self) -> str:
        return f"{self.words} [{self.constraint}]"


def nearest(found: object, known: Iterable[object]) -> str:
    """Return the end of a message about an unknown name: the nearest known name."""
    from difflib import get_close_matches  # noqa: PLC0415 - only for messages

    near = get_close_matches(str(found), [str(name) for name in known], 1)
    return "".join(f"; did you mean '{name}'?" for name in near)


def expected(found: object, known: Iterable[object], what: str = "one of") -> str:
    """Return the same after a list of all known names."""
    names = [str(name) for name in known]
    return f"expected {what} {', '.join(names) or '(there is none)'}{nearest(found, names)}"


def counted(number: int, nouns: str) -> str:
    """Return ``1 robot``, ``2 robots``, ``1 weakness`` or ``2 weaknesses``."""
    plural = "es" if nouns.endswith("sses") else "s"
    return f"{number} {nouns.removesuffix(plural) if number == 1 else nouns}"


def printable(text: str) -> str:
    """Return text in one line of printable characters."""
    line = " ".join(text.split())
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)


def time_left(seconds: float) -> str:
    """Return how long a command may still take: ``left 1:05``."""
    minutes, rest = divmod(round(seconds), 60)
    return f"left {minutes}:{rest:02d}"


class MrsfiError(Exception):
    """Base of all errors of mrsfi."""

    exit_code: ClassVar[int] = 1


class UsageError(MrsfiError):
    """A setting or an argument makes no sense."""

    exit_code = 2


class ModelError(MrsfiError):
    """A metamodel or model cannot be used; the message lists every defect found."""

    exit_code = 3


class GenerationError(MrsfiError):
    """Generation is impossible, or generated code is stale."""

    exit_code = 4


class ProtectedRegionError(GenerationError):
    """Generation would lose hand-written code."""


class SpecificationError(MrsfiError):
    """A fault specification cannot be flown on its mission; ``faults`` has the IDs concerned."""

    exit_code = 5

    def __init__(self, message: str, faults: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.faults = faults


class EvaluationError(MrsfiError):
    """The decision logic of a mission raised an error in an evaluation, or would do so.

    ``line`` is the file and line of generated code, if there is one; the message names both.
    """

    exit_code = 6
    line: tuple[Path, int] | None = None


class WorkerLost(EvaluationError):
    """A process died during an evaluation; the specification may not be the reason."""


class ReplayMismatch(MrsfiError):
    """A replay differs from the evaluation it repeats."""

    exit_code = 7


class TransportError(MrsfiError):
    """Messages between the two sides of a mission were lost."""

    exit_code = 8


class TransportTimeout(TransportError):
    """The other side did not answer in time."""


class TransportClosed(TransportError):
    """The connection is gone."""


class ProtocolError(TransportError):
    """The other side violated the protocol."""


class RecordError(MrsfiError):
    """A campaign folder cannot be read, written or flown by this mrsfi."""

    exit_code = 9


class LimitExceeded(MrsfiError):
    """A goal has more violations under a kept weakness than its limit allows."""

    exit_code = 10


class UndecidedWeakness(MrsfiError):
    """A weakness is neither kept nor decided on, or the decision has expired."""

    exit_code = 11
