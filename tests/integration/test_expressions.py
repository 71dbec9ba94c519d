"""Expressions that are written as the formatter writes them."""

import ast
import subprocess
import sys

from hypothesis import given
from hypothesis import strategies as st

from m2t.emit import Call, Table, expression


def is_formatted(source: str) -> bool:
    command = [sys.executable, "-m", "ruff", "format", "--isolated", "--line-length", "100"]
    done = subprocess.run(
        [*command, "--diff", "-"], input=source, text=True, capture_output=True, check=False
    )
    assert done.returncode in (0, 1), done.stderr
    return done.returncode == 0


def trees() -> st.SearchStrategy:
    words = st.text("ab'\" é\n\\{", max_size=30) | st.text("a", min_size=60, max_size=110)
    scalars = words | st.floats(allow_nan=False, allow_infinity=False) | st.integers() | st.none()

    def nested(inner: st.SearchStrategy) -> st.SearchStrategy:
        arguments = st.lists(inner, max_size=3).map(
            lambda values: tuple((f"argument_{i}", value) for i, value in enumerate(values))
        )
        return (
            st.lists(inner, max_size=3).map(tuple)
            | st.builds(Call, st.just("Robot"), arguments, st.booleans())
            | st.lists(inner, max_size=2).map(
                lambda values: Table(tuple((f"P{i}", value) for i, value in enumerate(values)))
            )
        )

    return st.recursive(scalars, nested, max_leaves=12).map(
        lambda tree: Call("Mission", (("value", tree),))
    )


def test_expression_is_what_the_formatter_would_write():
    collected = []

    @given(trees())
    def collect(tree):
        text = f"    return {expression(tree, 4, 7)}"
        ast.parse(f"def f():\n{text}\n")
        collected.append(text)

    collect()

    source = "\n\n".join(f"def f{i}():\n{text}\n" for i, text in enumerate(collected))
    assert is_formatted(source)
