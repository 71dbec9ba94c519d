"""What a user without dask is told."""

import subprocess
import sys

import pytest

from tests.tiers import slow

WITHOUT_DASK = """
import sys
sys.modules["distributed"] = None
from mrsfi_runtime.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


@slow
@pytest.mark.parametrize("command", ["evolve", "compare"])
def test_without_dask_the_user_is_told_what_to_install(tmp_path, command, approved):
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_DASK, command, "tight_margins", "--dask", "local"],
        check=False,
        cwd=tmp_path,
        capture_output=True,
        encoding="utf-8",
        timeout=60,
    )

    assert done.returncode == 2
    approved(done.stderr)
    assert not list(tmp_path.iterdir())
