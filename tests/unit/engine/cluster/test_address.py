import subprocess
import sys

import pytest

from mrsfi_runtime.engine.cluster.address import require_address
from mrsfi_runtime.errors import UsageError
from tests.support.cluster import require_dask

WITHOUT_DASK = """
import sys
sys.modules["distributed"] = None
from mrsfi_runtime.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize("text", ["local", "tcp://127.0.0.1:8786", "tls://[::1]:8786"])
def test_addresses_of_schedulers_are_taken(text: str) -> None:
    require_dask()

    require_address(text)


@pytest.mark.parametrize(
    "text",
    ["", "remote", "127.0.0.1:8786", "tcp://host", "tcp://:8786", "ws://host:1", "tcp://h:x"],
)
def test_what_is_no_address_is_refused_with_what_was_expected(text: str) -> None:
    require_dask()

    with pytest.raises(UsageError, match=r"expected tcp://HOST:PORT or tls://HOST:PORT"):
        require_address(text)


@pytest.mark.parametrize("command", ["evolve", "compare"])
def test_without_dask_the_user_is_told_what_to_install(tmp_path, command: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_DASK, command, "tight_margins", "--dask", "local"],
        check=False,
        cwd=tmp_path,
        capture_output=True,
        encoding="utf-8",
        timeout=60,
    )

    assert done.returncode == 2
    assert done.stderr == (
        "mrsfi: --dask needs dask.distributed; install it with: pip install 'mrsfi[dask]'\n"
    )
    assert not list(tmp_path.iterdir())
