"""What docs/api.md shows runs as it stands, and prints what the page says."""

import re
from contextlib import chdir, redirect_stdout
from io import StringIO

from tests.support.tree import ROOT

PAGE = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
SHOWN = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE, re.DOTALL)


def test_every_block_prints_what_stands_below_it(place):
    names: dict[str, object] = {}
    assert len(SHOWN) == PAGE.count("```python") == 3
    with chdir(place):
        for code, expected in SHOWN:
            printed = StringIO()
            with redirect_stdout(printed):
                exec(code, names)
            assert printed.getvalue() == expected
