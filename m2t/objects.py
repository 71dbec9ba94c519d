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
    """Loads a mission and its faults into one set of resources.

    Attributes
    ----------
    nodes
        Node of every object loaded so far.
    xmi_ids
        The xmi:id of every object whose element has one.
    """

    def __init__(self) -> None:
        self.nodes: dict[Any, Node] = {}
        self.xmi_ids: dict[Any, str] = {}
        self._objects: dict[Node, Any] = {}
        self._resources = ResourceSet()
        self._resources.resource_factory["xmi"] = _CheckedResource

    def load(self, tree: ModelTree) -> Any:
        """Return the root object of a model.

        Parameters
        ----------
        tree
            The model, sound in structure; the model that it refers to is loaded before it.
        """
        resource = self._resources.get_resource(_CheckedModel(tree), objects=self._objects)
        for node in resource.nodes:
            built = self._objects[node]
            self.nodes[built] = node
            if node.xmi_id is not None:
                self.xmi_ids[built] = node.xmi_id
        return resource.contents[0]

    def instance(self, node: Node) -> Any:
        """Return the object of a node; ``None`` if none was loaded."""
        return self._objects.get(node)


class _CheckedModel(URI):  # type: ignore[misc] # pyecore has no types
    """Where a resource finds a model that was read and checked already."""

    def __init__(self, tree: ModelTree) -> None:
        super().__init__(f"{tree.root.metaclass.ePackage.nsPrefix}.xmi")
        self.tree = tree


class _CheckedResource(XMIResource):  # type: ignore[misc] # pyecore has no types
    """A resource that is built from nodes; adds its objects to those of the models before it."""

    def __init__(self, uri: _CheckedModel, objects: dict[Node, Any]) -> None:
        super().__init__(uri)
        self.nodes: list[Node] = []
        self._objects = objects

    def load(self, options: Any = None) -> None:
        """Build all objects, then refer from one to the other."""
        self.options = options or {}
        tree = self.uri.tree
        self.append(self._built(tree.root))
        for reference, targets in tree.resolved:
            for target in targets:
                put(self._objects[reference.source], reference.slot, self._objects[target])

    def _built(self, node: Node) -> Any:
        """Return the object of a node with its attributes and all that it contains."""
        built = node.metaclass()
        self.nodes.append(node)
        self._objects[node] = built
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
