"""Load a checked model with pyecore, and pair its objects with the nodes of its files.

pyecore reads a canonical form of the model: one document with all its parts, usual prefixes,
no comments, references as paths such as ``//@goals.0/@messages.1``. What pyecore would
stumble over or misread is gone by then.
"""

from collections import Counter
from collections.abc import Iterator
from io import BytesIO
from typing import Any

from lxml import etree
from pyecore.ecore import EProxy
from pyecore.resources import URI, ResourceSet

from m2t.check.structure import ModelTree
from m2t.metamodels import Slot, load_metamodels, reference_type, slots
from m2t.read.model_files import XMI, XSI
from m2t.read.nodes import Node


class _CheckedFile(URI):  # type: ignore[misc] # pyecore has no types
    """A file that pyecore reads from memory."""

    def __init__(self, name: str, content: bytes) -> None:
        super().__init__(name)
        self._content = content

    def create_instream(self) -> BytesIO:
        """Return the content."""
        return BytesIO(self._content)

    def close_stream(self) -> None:
        """Do nothing: there is no file."""


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
        self._instances: dict[Node, Any] = {}
        self._addresses: dict[Node, str] = {}
        self._resources = ResourceSet()
        for package in load_metamodels().packages:
            self._resources.metamodel_registry[package.nsURI] = package

    def load(self, tree: ModelTree) -> Any:
        """Return the root object of a model.

        Parameters
        ----------
        tree
            The model, sound in structure; the model that it refers to is loaded before it.
        """
        name = f"{tree.root.metaclass.ePackage.nsPrefix}.xmi"
        content = etree.tostring(self._canonical(tree), encoding="UTF-8", xml_declaration=True)
        resource = self._resources.get_resource(_CheckedFile(name, content))
        self._resources.resources[name] = resource
        self._addresses.update((node, f"{name}#{path}") for node, path in _paths(tree.root))
        root = resource.contents[0]
        for node, instance in _pairs(tree.root, root):
            self._instances[node] = instance
            self.nodes[instance] = node
            if (XMI, "id") in node.qualified:
                self.xmi_ids[instance] = node.qualified[XMI, "id"]
        for reference, _ in tree.resolved:
            _replace_proxies(self._instances[reference.source], reference.feature)
        return root

    def instance(self, node: Node) -> Any:
        """Return the object of a node; ``None`` if none was loaded."""
        return self._instances.get(node)

    def _canonical(self, tree: ModelTree) -> etree._Element:
        package = tree.root.metaclass.ePackage
        prefixes = {"xmi": XMI, "xsi": XSI, package.nsPrefix: package.nsURI}
        root = etree.Element(f"{{{package.nsURI}}}{tree.root.metaclass.name}", nsmap=prefixes)
        elements = dict(_fill(tree.root, root))
        paths = dict(_paths(tree.root))
        for reference, targets in tree.resolved:
            element, name = elements[reference.source], reference.feature.name
            inside = [paths[target] for target in targets if target in paths]
            if inside:
                element.set(name, " ".join([*element.get(name, "").split(), *inside]))
            for target in targets:
                if target not in paths:
                    etree.SubElement(element, name, href=self._addresses[target])
        return root


def _fill(node: Node, element: etree._Element) -> Iterator[tuple[Node, etree._Element]]:
    """Write attributes and contained elements; yield every node with its element."""
    yield node, element
    known = slots(node.metaclass)
    for name, text in node.attributes.items():
        if not known[name].is_reference:
            element.set(name, text)
    for child in node.children:
        slot = known[child.tag]
        if slot.is_contained:
            contained = etree.SubElement(element, child.tag)
            if child.metaclass is not reference_type(slot.feature):
                kind = f"{child.metaclass.ePackage.nsPrefix}:{child.metaclass.name}"
                contained.set(f"{{{XSI}}}type", kind)
            yield from _fill(child, contained)
        elif not slot.is_reference:
            etree.SubElement(element, child.tag).text = child.text


def _pairs(node: Node, instance: Any) -> Iterator[tuple[Node, Any]]:
    """Yield every node with its object; both keep the order of the model within a feature."""
    yield node, instance
    for slot in _contained(node):
        children = [child for child in node.children if child.tag == slot.name]
        if children:
            value = instance.eGet(slot.feature)
            values = list(value) if slot.many else [value]
            for child, contained in zip(children, values, strict=True):
                yield from _pairs(child, contained)


def _replace_proxies(instance: Any, feature: Any) -> None:
    """Put the objects of the other model where pyecore left proxies of them."""
    value = instance.eGet(feature)
    if not feature.many:
        if isinstance(value, EProxy):
            instance.eSet(feature, value.force_resolve())
    elif any(isinstance(entry, EProxy) for entry in value):
        entries = [entry.force_resolve() if isinstance(entry, EProxy) else entry for entry in value]
        value.clear()
        value.extend(entries)


def _paths(node: Node, path: str = "/") -> Iterator[tuple[Node, str]]:
    """Yield every node with its path as Eclipse writes it."""
    yield node, path
    counts: Counter[str] = Counter()
    is_many = {slot.name: slot.many for slot in _contained(node)}
    for child in node.children:
        if child.tag in is_many:
            index = f".{counts[child.tag]}" if is_many[child.tag] else ""
            counts[child.tag] += 1
            yield from _paths(child, f"{'/' if path == '/' else path}/@{child.tag}{index}")


def _contained(node: Node) -> list[Slot]:
    return [slot for slot in slots(node.metaclass).values() if slot.is_contained]
