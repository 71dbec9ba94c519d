"""A copy of the tree in which a recipe is performed, and what was changed in it by hand."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.support.tree import ROOT

PARTS = ("m2t", "metamodels", "models", "generated", "src", "tests", "pyproject.toml")
ENGINES = ("reference", "compiled")
LEFT_OUT = shutil.ignore_patterns("*.mrsfi-*", "__pycache__", ".*")


class Tree:
    """A copy of the tree, whose own code runs in it; ``edited`` are files changed by hand."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.edited: set[str] = set()
        for name in PARTS:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, root / name, ignore=LEFT_OUT)
            else:
                shutil.copy(ROOT / name, root / name)
        self._require_own_code()

    def __truediv__(self, name: str) -> Path:
        return self.root / name

    @contextmanager
    def by_hand(self) -> Iterator[None]:
        """Count what changes meanwhile as edited by hand."""
        before = self._contents()
        yield
        after = self._contents()
        self.edited |= {name for name in before | after if before.get(name) != after.get(name)}

    def python(self, *words: str, expected: int = 0) -> str:
        """Run Python in the copy, on the copy's code; return what it prints."""
        done = subprocess.run(
            [sys.executable, *words],
            check=False,
            cwd=self.root,
            env=self._environment(),
            capture_output=True,
            encoding="utf-8",
        )
        if done.returncode != expected:
            told = done.stdout + done.stderr
            message = f"{' '.join(words)}: exit code {done.returncode}, not {expected}\n{told}"
            raise RuntimeError(message)
        return done.stdout

    def mrsfi(self, *words: str, expected: int = 0) -> str:
        """Run ``mrsfi`` in the copy; return what it prints."""
        return self.python("-m", "mrsfi_runtime.cli.main", *words, expected=expected)

    def mrsfi_json(self, *words: str) -> Any:
        """Run ``mrsfi … --json`` and return what it prints."""
        return json.loads(self.mrsfi(*words, "--json"))

    def _environment(self) -> Mapping[str, str]:
        return {
            "MRSFI_CACHE": str(ROOT / ".pytest_cache" / "mrsfi"),
            **os.environ,
            "PYTHONPATH": os.pathsep.join((str(self.root), str(self.root / "src"))),
            "PYTHONDONTWRITEBYTECODE": "1",
        }

    def _contents(self) -> dict[str, str]:
        return {
            path.relative_to(self.root).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(self.root.rglob("*"))
            if path.is_file() and path.relative_to(self.root).parts[0] != "runs"
        }

    def _require_own_code(self) -> None:
        where = "import m2t, mrsfi_runtime; print(m2t.__file__, mrsfi_runtime.__file__)"
        for path in self.python("-c", where).split():
            if not Path(path).is_relative_to(self.root):
                message = f"{path} runs in place of the copy in {self.root}"
                raise RuntimeError(message)
