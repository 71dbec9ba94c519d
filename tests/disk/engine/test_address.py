import pytest

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.engine_settings import require_address
from tests.support.cluster import require_dask


@pytest.mark.parametrize("text", ["local", "tcp://127.0.0.1:8786", "tls://[::1]:8786"])
def test_addresses_of_schedulers_are_taken(text):
    require_dask()

    require_address(text)


@pytest.mark.parametrize(
    "text",
    ["", "remote", "127.0.0.1:8786", "tcp://host", "tcp://:8786", "ws://host:1", "tcp://h:x"],
)
def test_what_is_no_address_is_refused_with_what_was_expected(text, refused):
    require_dask()

    with refused(UsageError):
        require_address(text)


def test_an_address_with_tls_is_refused_while_no_certificates_are_configured(refused):
    require_dask()
    from mrsfi_runtime.engine.cluster import Cluster

    with refused(UsageError):
        Cluster("tls://127.0.0.1:8786")
