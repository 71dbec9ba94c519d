"""What pages of the documentation show, run as a reader would, and compared with what is there.

A block of ``console`` has commands after ``$``, each with what it prints on a terminal; ``…``
stands for anything, on a line of its own for any lines. What a command prints on standard error may
be left out, because progress tells times; but of one that fails something is shown. A command that
ends with ``&`` stays until the page ends, one below whose lines stands ``^C`` until it has printed
them; both are interrupted, and have to end at that. A block of ``diff`` is an edit, applied in the
folder to which the commands before it have come; one of ``python`` whose first line is a comment
with a file's name is that file, there from the beginning. A comment ``<!-- not run: WHY -->`` right
above a block leaves it out.
"""

import os
import re
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

_FENCE = re.compile(
    r"(?P<left_out><!-- not run: [^>]+ -->\n\n?)?^```(?P<kind>\w+)\n(?P<body>.*?)^```$",
    re.DOTALL | re.MULTILINE,
)
_FILE = re.compile(r"# ([\w.]+)")
_ANY = "…"
_INTERRUPTED = "^C"
_PATIENCE_S = 60
_HOUR_S = 3600


@dataclass(frozen=True, slots=True)
class Block:
    """A block of a page: its kind, such as ``console``, its lines, and the number of the first."""

    kind: str
    lines: tuple[str, ...]
    line: int

    @property
    def file(self) -> str:
        """The file that this is, if it names one."""
        named = _FILE.fullmatch(self.lines[0]) if self.kind == "python" else None
        return named[1] if named else ""


@dataclass(frozen=True, slots=True)
class Said:
    """What a command printed: lines of standard output, and of standard error; its exit code."""

    output: tuple[str, ...]
    errors: tuple[str, ...]
    code: int = 0


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
        self._n_beside = 0

    def run(self, command: str) -> Said:
        """Run a command line where the one before it ended, in its environment."""
        left = f"code=$?\n{{ export -p; echo \"cd '$PWD'\"; }} > '{self._state}'\nexit $code"
        done = self._bash(f". '{self._state}'\n{command}\n{left}\n", "")
        return Said(_lines(done.stdout), _lines(done.stderr), done.returncode)

    @contextmanager
    def beside(self, command: str, n_lines: int) -> Iterator[Callable[[], Said]]:
        """Run a command beside the body, which begins when so many lines are printed, until Ctrl-C.

        Yields a function that tells what it has printed.
        """
        self._n_beside += 1
        files = [self._state.with_suffix(f".{name}{self._n_beside}") for name in ("out", "err")]

        def said() -> Said:
            return Said(*(_lines(file.read_text(encoding="utf-8")) for file in files))

        with files[0].open("wb") as out, files[1].open("wb") as err:
            running = subprocess.Popen(
                ["bash", "-c", f". '{self._state}'\n{command}\n"],
                cwd=self._folder,
                env=dict(self._environment),
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                start_new_session=True,
            )
        try:
            end = time.monotonic() + _PATIENCE_S
            while len(said().output) < n_lines and running.poll() is None:
                assert time.monotonic() < end, f"{command}: {said()}"
                time.sleep(0.05)
            yield said
        finally:
            try:
                with suppress(ProcessLookupError):
                    os.killpg(running.pid, signal.SIGINT)
                running.wait(_PATIENCE_S)
            finally:
                with suppress(ProcessLookupError):
                    os.killpg(running.pid, signal.SIGKILL)

    def write(self, name: str, lines: Sequence[str]) -> None:
        """Write a file where the shell stands."""
        target = self.run("pwd").output[0]
        (Path(target) / name).write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")

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
            timeout=_HOUR_S,
        )


def at_free_ports(text: str) -> str:
    """Return a page whose servers take free ports in place of their usual ones."""
    for command, usual in (("mrsfi bridge", 9090), ("dask scheduler", 8786)):
        with socket.create_server(("127.0.0.1", 0)) as server:
            port = server.getsockname()[1]
        text = text.replace(command, f"{command} --port {port}").replace(f":{usual}", f":{port}")
    return text


def run_page(text: str, terminal: Terminal) -> Iterator[tuple[str, Said]]:
    """Run the consoles and edits of a page in order, and yield each command that is as it stands.

    A command whose output is not what stands there fails with the page's line.
    """
    shown = list(blocks(text))
    for block in shown:
        if name := block.file:
            terminal.write(name, block.lines)
    with ExitStack() as until_the_end:
        for block in shown:
            if block.kind == "diff":
                terminal.edit(block.lines)
            elif block.kind == "console":
                for command, expected in commands(block):
                    said = _said(
                        terminal, command.partition("  #")[0].rstrip(), expected, until_the_end
                    )
                    wrong = difference([line for line in expected if line != _INTERRUPTED], said)
                    assert not wrong, f"line {block.line}: {command}\n{wrong}"
                    yield command, said


def _said(terminal: Terminal, command: str, expected: Sequence[str], stack: ExitStack) -> Said:
    if command.endswith(" &"):
        return stack.enter_context(terminal.beside(command.removesuffix(" &"), len(expected)))()
    if expected and expected[-1] == _INTERRUPTED:
        with terminal.beside(command, len(expected) - 1) as said:
            pass
        return said()
    return terminal.run(command)


def difference(expected: Sequence[str], said: Said) -> str:
    """Return what does not fit, as text; empty if what was said is what stands there."""
    wanted = [line.rstrip() for line in expected]
    free = [line for line in said.errors if line]
    shown = [line for line in wanted if line not in free]
    pattern = "".join(_pattern(line) for line in shown)
    printed = "".join(f"{line}\n" for line in said.output)
    fails_unseen = said.code and not set(wanted) - {_ANY}
    if not fails_unseen and re.fullmatch(
        pattern, printed.rstrip("\n") + "\n" if printed.strip() else ""
    ):
        return ""
    both = "\n".join((*said.output, *said.errors))
    return "expected:\n" + "\n".join(wanted) + "\n\nfound:\n" + both


def _pattern(line: str) -> str:
    if line == _ANY:
        return r"(?:.*\n)*?"
    return ".*".join(re.escape(part) for part in line.split(_ANY)) + r"\n"


def _lines(text: str) -> tuple[str, ...]:
    return tuple(line.rstrip() for line in text.rstrip("\n").splitlines())
