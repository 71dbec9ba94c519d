"""Which engine ``mrsfi simulate`` flies on."""

import pytest
from click.testing import CliRunner

from mrsfi_runtime.cli.simulate import command
from mrsfi_runtime.engine import rosbridge
from tests.support.tree import ROOT
from tests.tiers import slow


@slow
def test_auto_opens_no_server(monkeypatch):
    def refuse(*_, **__):
        pytest.fail("a rosbridge server")

    monkeypatch.setattr(rosbridge, "RosbridgeEngine", refuse)
    monkeypatch.chdir(ROOT)

    result = CliRunner().invoke(command, ["tight_margins", "--engine", "auto"])

    assert result.exit_code == 0, result.output
    assert "energy" in result.stdout
