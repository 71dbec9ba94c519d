"""On PYTHONPATH, it lets a test's processes leave figures empty, where nobody looks at them."""

from typing import Any

from mrsfi_runtime.analysis import summary

empty = {".png": b"", ".svg": b""}
replaced: Any = summary
replaced.drawn = lambda _: empty
