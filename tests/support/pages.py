"""What pages of the documentation show, run as a reader would, and compared with what is there.

A block of ``console`` has commands after ``$``, each with what it prints on a terminal; ``…``
stands for anything, on a line of its own for any lines. What a command prints on standard error may
be left out, because progress tells times. A block of ``diff`` is an edit, applied in the folder to
which the commands before it have come. A comment ``<!-- not run: WHY -->`` right above a block
leaves it out.
"""

import re
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

_FENCE = re.compile(
    r"(?P<left_out><!-- not run: [^>]+ -->\n\n?)?^```(?P<kind>\w+)\n(?P<body>.*?)^```$",
    re.DOTALL | re.MULTILINE,
)
_ANY = "…"


@dataclass(frozen=True, slots=True)
class Block:
    """A block of a page: its kind, such as ``console``, its lines, and the number of the first."""

    kind: str
    lines: tuple[str, ...]
    line: int


@dataclass(frozen=True, slots=True)
class Said:
    """What a command printed: lines of standard output, and those of standard error."""

    output: tuple[str, ...]
    errors: tuple[str, ...]


def blocks(text: str) -> Iterator[Block]:
    """Yield the blocks of a page that are to be run or that show something, in order."""
    for found in _FENCE.finditer(text):
        if not found["left_out"]:
            line = text.count("\n", 0, found.start("body")) + 1
            yield Block(found["kind"], tuple(found["body"].splitlines()), line)


def commands(block: Block) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the commands of a console with the lines that follow each."""
    at = [k for k, line in enumerate(block.lines) if line.startswith("$ ")]
    for begin, end in zip(at, [*at[1:], len(block.lines)], strict=True):
        yield block.lines[begin][2:], block.lines[begin + 1 : end]


class Terminal:
    """A shell that goes on from block to block.

    Parameters
    ----------
    folder
        Where it begins.
    environment
        In place of that of the tests.
    """

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self._folder = folder
        self._environment = environment
        self._state = folder.parent / f"{folder.name}.state"
        self._state.write_text(f"cd {folder}\n", encoding="utf-8")

    def run(self, command: str) -> Said:
        """Run a command line where the one before it ended, in its environment."""
        left = f"{{ export -p; echo \"cd '$PWD'\"; }} > '{self._state}'"
        done = self._bash(f". '{self._state}'\n{command}\n{left}\n", "")
        return Said(_lines(done.stdout), _lines(done.stderr))

    def edit(self, difference: Sequence[str]) -> None:
        """Apply an edit, which must fit as it stands."""
        script = f". '{self._state}'\nexec patch --strip 1 --fuzz 0 --no-backup-if-mismatch\n"
        done = self._bash(script, "".join(f"{line}\n" for line in difference))
        assert done.returncode == 0, done.stdout + done.stderr

    def _bash(self, script: str, given: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["bash", "-c", script],
            cwd=self._folder,
            env=dict(self._environment),
            input=given,
            capture_output=True,
            text=True,
            check=False,
        )


def run_page(text: str, terminal: Terminal) -> Iterator[tuple[str, Said]]:
    """Run the consoles and edits of a page in order, and yield each command that is as it stands.

    A command whose output is not what stands there fails with the page's line.
    """
    for block in blocks(text):
        if block.kind == "diff":
            terminal.edit(block.lines)
        elif block.kind == "console":
            for command, expected in commands(block):
                said = terminal.run(command.partition("  #")[0])
                wrong = difference(expected, said)
                assert not wrong, f"line {block.line}: {command}\n{wrong}"
                yield command, said


def difference(expected: Sequence[str], said: Said) -> str:
    """Return what does not fit, as text; empty if what was said is what stands there."""
    wanted = [line.rstrip() for line in expected]
    free = [line for line in said.errors if line]
    shown = [line for line in wanted if line not in free]
    pattern = "".join(_pattern(line) for line in shown)
    printed = "".join(f"{line}\n" for line in said.output)
    if re.fullmatch(pattern, printed.rstrip("\n") + "\n" if printed.strip() else ""):
        return ""
    both = "\n".join((*said.output, *said.errors))
    return "expected:\n" + "\n".join(wanted) + "\n\nfound:\n" + both


def _pattern(line: str) -> str:
    if line == _ANY:
        return r"(?:.*\n)*?"
    return ".*".join(re.escape(part) for part in line.split(_ANY)) + r"\n"


def _lines(text: str) -> tuple[str, ...]:
    return tuple(line.rstrip() for line in text.rstrip("\n").splitlines())
