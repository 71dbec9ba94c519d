"""Write a fault specification that search found as a model that Eclipse opens.

References
----------
Source paper, section III-A, step 6, and section III-B b).
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from m2t.constraints.fault_rules import fault_types
from m2t.load import LoadedModels, load_mission_folder
from m2t.metaclasses import copies, slots
from m2t.metamodels import load_metamodels, meaning
from m2t.saving import addresses
from m2t.write.xmi import dumps
from mrsfi_runtime.errors import SpecificationError, expected
from mrsfi_runtime.files import write_atomically
from mrsfi_runtime.model.faults import at_work, numbered
from mrsfi_runtime.project_file import metamodels_chosen

SpecificationRow: TypeAlias = (
    tuple[str, int, int, Mapping[str, float]] | tuple[str, int, int, Mapping[str, float], str]
)
"""ID of a pool fault, first tick, last tick, and values by parameter name; the ID of a trigger."""


@metamodels_chosen()
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
    ``numbered`` if left out; display names are those of the pool. Triggers that faults wait for are
    copied, those of effects with the timed faults whose effects they are. What the pool lacks, or
    the gate refuses, is a SpecificationError.
    """
    models = load_mission_folder(models) if isinstance(models, Path) else models
    folder = models.mission_path.parent
    pool = {fault.ID: fault for fault in models.pool}
    specification = load_metamodels().faults_class()
    specification.ID = identifier
    names = numbered(row[0] for row in rows) if names is None else names
    for name, (fault_id, start, finish, given, *_) in zip(names, rows, strict=True):
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
    _set_triggers(models, specification, rows)
    hrefs = addresses(models, path.parent)
    write(path, dumps(specification, hrefs=hrefs, xmi_ids=models.xmi_ids))


def _set_triggers(
    models: LoadedModels, specification: Any, rows: Sequence[SpecificationRow]
) -> None:
    """Have timed faults wait for copies of the pool's triggers, as their rows say."""
    known = {} if models.faults is None else {each.ID: each for each in models.faults.triggers}
    waited = ["".join(row[4:]) for row in rows]
    for trigger in waited:
        if trigger and trigger not in known:
            what = f"trigger '{trigger}' is not in the pool of {models.mission_path.parent}"
            raise SpecificationError(f"{what}; {expected(trigger, known)}")
    made = copies(known[each] for each in known if each in waited)
    specification.triggers.extend(made[known[each]] for each in known if each in waited)
    for original, copy in made.items():
        if original in known.values():
            sources = {fault.ID for fault in original.faults}
            copy.faults.clear()
            timed = zip(specification.faults, rows, strict=True)
            copy.faults.extend(fault for fault, row in timed if row[0] in sources)
    for fault, trigger in zip(specification.faults, waited, strict=True):
        fault.trigger = made[known[trigger]] if trigger else None
