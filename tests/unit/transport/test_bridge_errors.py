"""Errors of the embedded server, as errors of the runtime."""

import pytest

from mrsfi_bridge import errors as bridge
from mrsfi_bridge.structures import FieldError
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.rosbridge import as_ours


@pytest.mark.parametrize("theirs", [bridge.BridgeError, *bridge.BridgeError.__subclasses__()])
def test_message_and_exit_code_stay(theirs):
    ours = as_ours(theirs("why"))

    assert (str(ours), ours.exit_code) == ("why", theirs.exit_code)


def test_a_field_that_does_not_fit_is_an_error_of_the_protocol():
    assert type(as_ours(FieldError("why"))) is ProtocolError
