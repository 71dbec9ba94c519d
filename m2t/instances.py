"""Load a checked file with pyecore, and pair its objects with the nodes of the file.

pyecore reads a canonical form of the file: usual prefixes, no comments, references as paths
such as ``//@goals.0/@messages.1``. What it would misread or stumble over is gone by then.
"""

from collections import Counter
from collections.abc import Iterator
from io import BytesIO
from typing import Any

from lxml import etree
from pyecore.ecore import EProxy
from pyecore.resources import URI, ResourceSet

from m2t.document import Node
from m2t.metamodels import features, is_contained, is_reference, load_metamodels
from m2t.structure import XMI, XSI, ModelTree


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
    """Loads the files of one mission into one set of resources.

    Attributes
    ----------
    nodes
        Node of every object loaded so far.
    """

    def __init__(self) -> None:
        self.nodes: dict[Any, Node] = {}
        self._resources = ResourceSet()
        self._addresses: dict[Node, str] = {}
        for package in load_metamodels().packages:
            self._resources.metamodel_registry[package.nsURI] = package

    def load(self, tree: ModelTree) -> Any:
        """Return the root object of a file.

        Parameters
        ----------
        tree
            The file, sound in structure; files that it refers to are loaded before it.
        """
        name = f"{tree.root.metaclass.ePackage.nsPrefix}.xmi"
        root_element = self._canonical(tree)
        content = etree.tostring(root_element, encoding="UTF-8", xml_declaration=True)
        resource = self._resources.get_resource(_CheckedFile(name, content))
        self._resources.resources[name] = resource
        self._addresses.update((node, f"{name}#{path}") for node, path in _paths(tree.root))
        root = resource.contents[0]
        pairs = dict(_pairs(tree.root, root))
        self.nodes.update((instance, node) for node, instance in pairs.items())
        for reference, _ in tree.resolved:
            _replace_proxies(pairs[reference.source], reference.feature)
        return root

    def _canonical(self, tree: ModelTree) -> etree._Element:
        package = tree.root.metaclass.ePackage
        prefixes = {"xmi": XMI, "xsi": XSI, package.nsPrefix: package.nsURI}
        root = etree.Element(f"{{{package.nsURI}}}{tree.root.metaclass.name}", nsmap=prefixes)
        elements = dict(_fill(tree.root, root))
        paths = dict(_paths(tree.root))
        for reference, targets in tree.resolved:
            element, name = elements[reference.source], reference.feature.name
            for target in targets:
                if target in paths:
                    element.set(name, f"{element.get(name, '')} {paths[target]}".lstrip())
                else:
                    etree.SubElement(element, name, href=self._addresses[target])
        return root


def _fill(node: Node, element: etree._Element) -> Iterator[tuple[Node, etree._Element]]:
    """Write attributes and contained elements; yield every node with its element."""
    yield node, element
    by_name = {feature.name: feature for feature in _features(node)}
    for name, text in node.attributes.items():
        if not is_reference(by_name[name]):
            element.set(name, text)
    for child in node.children:
        feature = by_name[child.tag]
        if is_contained(feature):
            contained = etree.SubElement(element, child.tag)
            if (XSI, "type") in child.qualified:
                kind = f"{child.metaclass.ePackage.nsPrefix}:{child.metaclass.name}"
                contained.set(f"{{{XSI}}}type", kind)
            yield from _fill(child, contained)
        elif not is_reference(feature):
            etree.SubElement(element, child.tag).text = child.text


def _pairs(node: Node, instance: Any) -> Iterator[tuple[Node, Any]]:
    """Yield every node with its object; both keep the order of the file within a feature."""
    yield node, instance
    for feature in filter(is_contained, _features(node)):
        value = instance.eGet(feature)
        values = list(value) if feature.many else [value] if value is not None else []
        children = [child for child in node.children if child.tag == feature.name]
        for child, contained in zip(children, values, strict=True):
            yield from _pairs(child, contained)


def _replace_proxies(instance: Any, feature: Any) -> None:
    """Put the objects of other files where pyecore left proxies of them."""
    value = instance.eGet(feature)
    if not feature.many:
        if isinstance(value, EProxy):
            instance.eSet(feature, value.force_resolve())
    elif any(isinstance(entry, EProxy) for entry in value):
        entries = [entry.force_resolve() if isinstance(entry, EProxy) else entry for entry in value]
        value.clear()
        value.extend(entries)


def _features(node: Node) -> tuple[Any, ...]:
    return features(node.metaclass)


def _paths(node: Node, path: str = "/") -> Iterator[tuple[Node, str]]:
    """Yield every node with its path as Eclipse writes it."""
    yield node, path
    counts: Counter[str] = Counter()
    is_many = {feature.name: feature.many for feature in _features(node)}
    for child in node.children:
        if child.metaclass is not None:
            index = f".{counts[child.tag]}" if is_many[child.tag] else ""
            counts[child.tag] += 1
            yield from _paths(child, f"{'/' if path == '/' else path}/@{child.tag}{index}")
