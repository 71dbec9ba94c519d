"""A law: what a team adds to its metamodels and uses in its models is never dropped.

Each addition that a model uses is found in generated code, or refused with file and line.
"""

import re
import shutil
from pathlib import Path
from random import Random

import pytest

from m2t.generate import generate
from m2t.load import load_mission_folder
from m2t.metamodels import FAULTS_FILE
from m2t.write.xmi import dumps
from mrsfi_runtime.errors import ModelError
from tests.support.cli import MISSION, ROOT
from tests.support.own_metamodels import add_feature, attribute, copy_metamodels, metamodels_of

VALUES = {"EString": "own text", "EInt": 77, "EDouble": 7.75, "EBoolean": True}
_CLASS = re.compile(r'<eClassifiers xsi:type="ecore:EClass" name="(\w+)"')


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("file", [FAULTS_FILE])
def test_an_attribute_that_a_team_adds_is_generated_or_refused_by_line(
    tmp_path: Path, file: str, seed: int
) -> None:
    rng = Random(seed)
    metamodels = tmp_path / "metamodels"
    copy_metamodels(metamodels)
    name = rng.choice(_CLASS.findall((metamodels / file).read_text(encoding="utf-8")))
    kind, many = rng.choice([*VALUES]), rng.choice(("", 'upperBound="-1"'))
    add_feature(metamodels / file, name, attribute("ownAddition", kind, many))

    try:
        with metamodels_of(metamodels):
            models = _using(tmp_path, VALUES[kind])
            generate(models, tmp_path / "generated")
    except ModelError as error:
        found = re.findall(r"\.(?:ecore|xmi):\d+: [^\n]*ownAddition", str(error))
    else:
        files = (tmp_path / "generated").glob("*.py")
        found = [path for path in files if "ownAddition" in path.read_text(encoding="utf-8")]

    assert found, f"{kind} {many} of {name}"


def _using(folder: Path, value: object) -> Path:
    """Return a copy of the models in which the addition has a value wherever there is one."""
    models = folder / "models" / MISSION
    shutil.copytree(ROOT / "models" / MISSION, models)
    loaded = load_mission_folder(models)
    n_used = 0
    for root in (loaded.mission, loaded.faults):
        for element in (root, *root.eAllContents()):
            feature = element.eClass.findEStructuralFeature("ownAddition")
            if feature is not None:
                element.eSet(feature, [value] if feature.many else value)
                n_used += 1
    assert n_used
    (models / "mission.xmi").write_bytes(dumps(loaded.mission))
    faults = dumps(loaded.faults, hrefs={loaded.mission: "mission.xmi"})
    (models / "faults.xmi").write_bytes(faults)
    return models
