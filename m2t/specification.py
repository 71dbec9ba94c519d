"""Write a fault specification that search found as a model that Eclipse opens.

References
----------
Source paper, section III-A, step 6, and section III-B b).
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from m2t.constraints.fault_rules import fault_types
from m2t.load import LoadedModels, load_mission_folder
from m2t.metaclasses import copies, slots
from m2t.metamodels import load_metamodels, meaning
from m2t.saving import addresses
from m2t.write.xmi import dumps
from mrsfi_runtime.errors import SpecificationError, expected
from mrsfi_runtime.files import write_atomically
from mrsfi_runtime.model.faults import numbered
from mrsfi_runtime.model.gate import at_work

SpecificationRow: TypeAlias = tuple[str, int, int, Mapping[str, float]]
"""ID of a pool fault, first tick, last tick, and values by parameter name."""


def write_specification(
    models: Path | LoadedModels,
    rows: Sequence[SpecificationRow],
    path: Path,
    *,
    identifier: str,
    names: Sequence[str] | None = None,
    write: Callable[[Path, bytes], object] = write_atomically,
) -> None:
    """Write timed faults as XMI, in their order, a file that is replaced as a whole.

    ``models`` is the mission folder, or what was loaded from one, whose ``faults.xmi`` is the pool;
    ``identifier`` the ID of the specification. ``names`` are the IDs of the timed faults, those of
    ``numbered`` if left out; display names are those of the pool. What the pool lacks, or the gate
    refuses, is a SpecificationError.
    """
    models = load_mission_folder(models) if isinstance(models, Path) else models
    folder = models.mission_path.parent
    pool = {fault.ID: fault for fault in models.pool}
    specification = load_metamodels().faults_class()
    specification.ID = identifier
    names = numbered(row[0] for row in rows) if names is None else names
    for name, (fault_id, start, finish, given) in zip(names, rows, strict=True):
        if fault_id not in pool:
            what = f"fault '{fault_id}' is not in the pool of {folder}"
            raise SpecificationError(f"{what}; {expected(fault_id, pool)}")
        fault = copies([pool[fault_id]])[pool[fault_id]]
        (kind,) = fault_types(fault)
        means = meaning(kind)
        usual = {known.name: getattr(kind, known.name) for known in means.parameters}
        timed = at_work(fault_id, means, start, finish, {**usual, **given})
        fault.ID, fault.start, fault.finish = name, timed.start, timed.finish
        for known, value in zip(means.parameters, timed.values, strict=True):
            if known.name in given:
                is_integer = slots(kind.eClass)[known.name].type.name == "EInt"
                setattr(kind, known.name, int(value) if is_integer else value)
        specification.faults.append(fault)
    hrefs = addresses(models, path.parent)
    write(path, dumps(specification, hrefs=hrefs, xmi_ids=models.xmi_ids))
