"""Build the objects of checked models straight from their nodes.

pyecore loads them as it loads any other resource of a resource set; only its reader, which lets
most defects of a file pass and stumbles over others, is not asked.
"""

from typing import Any

from pyecore.resources import URI, ResourceSet
from pyecore.resources.xmi import XMIResource

from m2t.check.structure import ModelTree
from m2t.elements import put
from m2t.metaclasses import Slot, slots
from m2t.read.nodes import Node


class ModelLoader:
    """Loads a mission and its faults as resources of one set; knows the node of every object."""

    def __init__(self) -> None:
        self.nodes: dict[Any, Node] = {}
        self.objects: dict[Node, Any] = {}
        self._resources = ResourceSet()
        self._resources.resource_factory["xmi"] = _CheckedResource

    def load(self, tree: ModelTree) -> Any:
        """Return the root object of a sound model; what it refers to is loaded before it."""
        uri = URI(f"{tree.root.metaclass.ePackage.nsPrefix}.xmi")
        return self._resources.get_resource(uri, tree=tree, loader=self).contents[0]


class _CheckedResource(XMIResource):  # type: ignore[misc] # pyecore has no types
    """A resource that is built from nodes that were read and checked already."""

    def __init__(self, uri: URI, tree: ModelTree, loader: ModelLoader) -> None:
        super().__init__(uri)
        self._tree = tree
        self._loader = loader

    def load(self, options: Any = None) -> None:
        """Build all objects, then refer from one to the other."""
        self.options = options or {}
        self.append(self._built(self._tree.root))
        objects = self._loader.objects
        for reference, targets in self._tree.resolved:
            for target in targets:
                put(objects[reference.source], reference.slot, objects[target])

    def _built(self, node: Node) -> Any:
        """Return the object of a node with its attributes and all that it contains."""
        built = node.metaclass()
        self._loader.nodes[built] = node
        self._loader.objects[node] = built
        known = slots(node.metaclass)
        for name, text in node.attributes.items():
            slot = known[name]
            if not slot.is_reference:
                for each in text.split() if slot.many else [text]:
                    self._assign(built, slot, each)
        for child in node.children:
            slot = known[child.tag]
            if slot.is_contained:
                put(built, slot, self._built(child))
            elif not slot.is_reference:
                self._assign(built, slot, child.text)
        return built

    def _assign(self, built: Any, slot: Slot, text: str) -> None:
        put(built, slot, slot.type.from_string(text))
        if slot.is_id:
            self.uuid_dict[text] = built
