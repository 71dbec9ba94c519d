"""Generated code with other bodies in its regions."""

from pathlib import Path
from shutil import copyfile, copytree

from tests.support.tree import ROOT

COLLECTIVE = "collective_intelligence.py"
REGION = "g1.check"


def write_body(path: Path, region: str, body: str) -> int:
    """Write another body into a region of a file, and return the line of the body's first line."""
    text = path.read_text(encoding="utf-8")
    begin = f"# protected region {region} on begin\n"
    before, found, rest = text.partition(begin)
    assert found, f"{path.name} has no region {region}"
    end = before[before.rfind("\n") + 1 :] + f"# protected region {region} end\n"
    head = before + begin
    path.write_text(head + body + end + rest.partition(end)[2], encoding="utf-8")
    return head.count("\n") + 1


def edited(folder: Path, region: str, body: str, mission: str = "uuv_sampling") -> Path:
    """Return a copy of the generated code of a mission with another body in one region."""
    copy = Path(copytree(ROOT / "generated" / mission, folder / "edited"))
    write_body(copy / COLLECTIVE, region, body)
    return copy


def indented(body: str) -> str:
    """Return lines as they stand in the region of a function."""
    return "".join(f"    {line}\n" for line in body.splitlines())


def write_region(folder: Path, body: str, helpers: str = "") -> int:
    """Write the paper's collective intelligence with another body of ``REGION``.

    Parameters
    ----------
    folder
        Where the file is written.
    body
        Lines of the region.
    helpers
        Lines for the region of the helpers, imports included.

    Returns
    -------
    int
        Line of the first line of the body.
    """
    folder.mkdir(exist_ok=True)
    path = Path(copyfile(ROOT / "generated" / "uuv_sampling" / COLLECTIVE, folder / COLLECTIVE))
    write_body(path, "helpers", helpers)
    return write_body(path, REGION, indented(body))
