"""Which engine ``mrsfi simulate`` flies on."""

import pytest
from click.testing import CliRunner

from mrsfi_runtime.cli.commands.simulate import command
from mrsfi_runtime.engine import rosbridge
from tests.support.tree import ROOT
from tests.tiers import slow


@slow
@pytest.mark.parametrize("options", [["--engine", "auto"], ["--each-fault", "60:180"]])
def test_auto_opens_no_server(options, monkeypatch):
    def refuse(*_, **__):
        pytest.fail("a rosbridge server")

    monkeypatch.setattr(rosbridge, "RosbridgeEngine", refuse)
    monkeypatch.chdir(ROOT)

    result = CliRunner().invoke(command, ["tight_margins", *options])

    assert result.exit_code == 0, result.output
    assert "energy" in result.stdout
