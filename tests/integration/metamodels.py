"""Small metamodels, and static classes generated from them into folders of any name."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from pyecore.ecore import (
    EAnnotation,
    EAttribute,
    EClass,
    EEnum,
    EEnumLiteral,
    EInt,
    EPackage,
    EReference,
    EString,
)

from m2t.classes import class_files, write_classes

HOSTILE = 'Ends a text: """, \'\'\'; escapes: \\ \\n; a line\nand more; é \u2028 {{ x }}"'
"""Documentation that is text in every language but the one it is written into."""


def package(name: str, *classifiers: Any) -> Any:
    """Return a package."""
    result = EPackage(name, nsURI=f"http://example.org/{name}", nsPrefix=name)
    result.eClassifiers.extend(classifiers)
    return result


def metaclass(name: str, *features: Any, **properties: Any) -> Any:
    """Return a class."""
    result = EClass(name, **properties)
    result.eStructuralFeatures.extend(features)
    return result


def odd_package() -> Any:
    """Return a package with what is hard to keep in Python."""
    level = EEnum("Level")
    for name, value in (("LOW", 10), ("HIGH", -3)):
        level.eLiterals.append(EEnumLiteral(name, value))
    kind = EAttribute("class", EString, lower=1, iD=True)
    kind.eAnnotations.append(_annotation("http://example.org/note", key="a 'word'", other='"\\'))
    node = metaclass(
        "Node",
        kind,
        EAttribute("level", level, defaultValueLiteral="HIGH", unsettable=True),
        EAttribute("words", EString, upper=-1, unique=False),
        EAttribute("count", EInt, defaultValueLiteral="7"),
    )
    node.eAnnotations.append(
        _annotation("http://www.eclipse.org/emf/2002/GenModel", documentation=HOSTILE)
    )
    node.eStructuralFeatures.append(EReference("children", node, upper=-1, containment=True))
    return package("odd", node, level)


def _annotation(source: str, **details: str) -> Any:
    annotation = EAnnotation(source)
    annotation.details.update(details)
    return annotation


def load_generated(folder: Path, *packages: Any) -> dict[str, ModuleType]:
    """Generate classes into a folder, which becomes a package of its own name; import them."""
    write_classes(folder, class_files(packages))
    spec = importlib.util.spec_from_file_location(
        folder.name, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert spec is not None
    assert spec.loader is not None
    sys.modules[folder.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[folder.name])
    return {
        package.name: importlib.import_module(f"{folder.name}.{package.name}")
        for package in packages
    }
