"""The paper's generated code, with one region replaced."""

from pathlib import Path
from shutil import copytree

from tests.support.tree import ROOT

GENERATED = ROOT / "generated" / "uuv_sampling"


def edited(tmp_path: Path, region: str, body: str) -> Path:
    """Return a copy of the generated code with one region replaced."""
    folder = Path(copytree(GENERATED, tmp_path / "edited"))
    path = folder / "collective_intelligence.py"
    text = path.read_text(encoding="utf-8")
    begin = f"    # protected region {region} on begin\n"
    end = f"    # protected region {region} end\n"
    head, rest = text.split(begin)
    path.write_text(head + begin + body + end + rest.split(end)[1], encoding="utf-8")
    return folder
