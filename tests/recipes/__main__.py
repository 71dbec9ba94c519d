"""Perform the recipes and print a table; name some of them, or none for all.

Run as ``python -m tests.recipes [RECIPE …]`` on the tree. A file counts if it was edited
by hand: added or changed, a region of generated code included. What only uses the new thing, a
model or a campaign file, is listed apart, and so is how many files were generated anew.
"""

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.recipes.performed import RECIPES, Performed, perform


def lines(name: str, done: Performed) -> Iterator[str]:
    """Yield what the table says of a recipe."""
    yield f"{name}: {len(done.edited)} edited, {len(done.generated)} generated anew"
    yield from (f"    edited  {path}" for path in done.edited)
    yield from (f"    in use  {path}" for path in done.using)
    for what, digests in done.digests.items():
        yield from (f"    {what}  {digest}  {engine}" for engine, digest in digests.items())


def main(names: list[str]) -> int:
    """Perform recipes and print what came of each; return 1 where digests differ."""
    is_alike = True
    for name in names or RECIPES:
        with tempfile.TemporaryDirectory() as folder:
            done = perform(name, Path(folder) / "tree")
        print(*lines(name, done), sep="\n", flush=True)  # noqa: T201 - what it is for
        is_alike &= all(len({*digests.values()}) == 1 for digests in done.digests.values())
    return 0 if is_alike else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
