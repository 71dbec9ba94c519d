"""Write a fault specification that search found as a model that Eclipse opens.

References
----------
Source paper, section III-A, step 6, and section III-B b).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from m2t.constraints.faults import fault_types
from m2t.elements import copies
from m2t.load import LoadedModels, load_mission_folder
from m2t.metaclasses import slots
from m2t.metamodels import load_metamodels
from m2t.saving import addresses
from m2t.write.xmi import dumps
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.files import write_atomically
from mrsfi_runtime.model.faults import numbered

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
    """Write timed faults as XMI.

    Parameters
    ----------
    models
        Mission folder, or what was loaded from one; its ``faults.xmi`` is the pool.
    rows
        The timed faults, in the order in which they are written.
    path
        File to write, replaced as a whole.
    identifier
        ID of the fault specification.
    names
        IDs of the timed faults; those of ``numbered`` if left out.
    write
        What writes them.

    Raises
    ------
    ModelError
        If the models of the folder cannot be used.
    SpecificationError
        If a row names a fault or a parameter that the pool does not have, or gives a value
        that the parameter cannot hold.

    Notes
    -----
    The copies of a pool fault keep its name.
    """
    models = load_mission_folder(models) if isinstance(models, Path) else models
    folder = models.mission_path.parent
    pool = {fault.ID: fault for fault in models.pool}
    specification = load_metamodels().faults_class()
    specification.ID = identifier
    names = numbered(row[0] for row in rows) if names is None else names
    for name, (fault_id, start, finish, given) in zip(names, rows, strict=True):
        if fault_id not in pool:
            known = ", ".join(pool) or "none"
            raise SpecificationError(
                f"fault '{fault_id}' is not in the pool of {folder}; it has: {known}"
            )
        if not 0 <= start <= finish:
            raise SpecificationError(
                f"fault '{fault_id}' has window {start} ... {finish}; expected 0 <= start <= finish"
            )
        fault = copies([pool[fault_id]])[pool[fault_id]]
        fault.ID = name
        fault.start, fault.finish = start, finish
        _set_values(fault, given)
        specification.faults.append(fault)
    hrefs = addresses(models, path.parent)
    write(path, dumps(specification, hrefs=hrefs, xmi_ids=models.xmi_ids))


def _set_values(fault: Any, given: Mapping[str, float]) -> None:
    """Set the parameters of a fault."""
    (kind,) = fault_types(fault)
    for name, value in given.items():
        slot = slots(kind.eClass).get(name)
        if slot is None:
            raise SpecificationError(
                f"fault '{fault.ID}' ({kind.eClass.name}) has no parameter '{name}'; "
                "give only those of its type"
            )
        is_integer = slot.type.name == "EInt"
        if not math.isfinite(value) or (is_integer and value != int(value)):
            expected = "a whole number" if is_integer else "a finite number"
            raise SpecificationError(f"fault '{fault.ID}' has {name} {value}; expected {expected}")
        setattr(kind, name, int(value) if is_integer else float(value))
