"""What breaks the goals of a mission at the least, as a campaign has found out, and files of it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

from mrsfi.campaign_folders import OpenCampaign
from mrsfi.loading import specification_writer
from mrsfi_runtime.analysis import fault_tree, fmea
from mrsfi_runtime.analysis.report import specification_rows
from mrsfi_runtime.causes.cover import covered
from mrsfi_runtime.causes.weakness import Known, Weakness
from mrsfi_runtime.errors import RecordError, UsageError
from mrsfi_runtime.files import changing, whole_file
from mrsfi_runtime.model.faults import numbered
from mrsfi_runtime.record.settings import COVERING
from mrsfi_runtime.search.space import SearchSpace

FMEA = MappingProxyType({".csv": fmea.as_csv, ".md": fmea.as_markdown})
FAULT_TREES = MappingProxyType(
    {".xml": fault_tree.as_open_psa, ".txt": fault_tree.as_pfta, ".pft": fault_tree.as_pfta}
)
"""What files are written as, by what their names end in."""

T = TypeVar("T")


def format_of(path: Path, known: Mapping[str, T]) -> T:
    """Return what a file is to be written as; a name that ends otherwise is a ``UsageError``."""
    if path.suffix not in known:
        wanted = f"a name that ends in {' or '.join(known)}"
        raise UsageError(f"{path}: found the ending '{path.suffix}'; expected {wanted}")
    return known[path.suffix]


def known_by(campaign: OpenCampaign) -> Known:
    """Return what a campaign that covers has found until now; another one is a ``RecordError``."""
    store = campaign.store
    if store.settings.algorithm != COVERING:
        raise RecordError(
            f"{campaign.folder.path}: was searched by '{store.settings.algorithm}', which seeks "
            f"the worst specifications; expected a campaign of '{COVERING}'; begin one with: mrsfi "
            f"evolve {store.manifest.place or store.manifest.mission} --algorithm {COVERING}"
        )
    flown = {each.specification: each.outcome for each in store.evaluations()}
    outcomes = flown | {each.specification: None for each in store.failures()}
    space = SearchSpace.of(campaign.mission, campaign.pool)
    return covered(space, store.settings, outcomes)


def write_forms(campaign: OpenCampaign, found: Sequence[Weakness], folder: Path) -> list[Path]:
    """Write the form of each weakness into a folder as a fault specification: all, or none.

    What cannot be written is a ``UsageError``.
    """
    contents: dict[Path, bytes | None] = {}
    write = specification_writer(campaign.folder.model, contents.__setitem__)
    for (_, form), name in fmea.forms(campaign.mission, found).items():
        rows = specification_rows(campaign.pool, form)
        names = numbered(timed.fault for timed in form)
        write(rows, folder / f"{name}.xmi", name.replace("-", "_"), names)
    with changing(folder) as change:
        change.replace(contents)
    return [*contents]


def write_fmea(
    campaign: OpenCampaign, found: Sequence[Weakness], record: fmea.Record, path: Path
) -> None:
    """Write failure modes and effects, flown in the campaign's mission seed.

    What cannot be written, or ends otherwise than those of ``FMEA``, is a ``UsageError``.
    """
    write = format_of(path, FMEA)
    modes = fmea.failure_modes(campaign.mission, campaign.pool, found, record)
    with whole_file(path) as file:
        file.write(write(campaign.mission, modes))


def write_fault_trees(campaign: OpenCampaign, found: Sequence[Weakness], path: Path) -> None:
    """Write the fault tree of each goal; errors as in ``write_fmea``, by ``FAULT_TREES``."""
    write = format_of(path, FAULT_TREES)
    with whole_file(path) as file:
        file.write(write(campaign.mission, campaign.pool, found))
