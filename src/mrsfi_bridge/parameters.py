"""Parameters: values under names like ``/robot/speed``, kept while the server runs."""

import json
from collections.abc import Iterator
from typing import Any

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.names import absolute, check_name

_DEEPEST = 32
_TOTAL_BYTES = 1 << 24


class Parameters:
    """A tree of values; a name with others below it stands for all of them.

    Parameters
    ----------
    max_parameters
        Leaves of the tree.
    max_bytes
        Longest value, as JSON text.
    """

    def __init__(self, max_parameters: int, max_bytes: int) -> None:
        self._max_parameters = max_parameters
        self._max_bytes = max_bytes
        self._leaves: dict[str, str] = {}
        self._n_bytes = 0

    @property
    def names(self) -> list[str]:
        """Names of all leaves, in the order in which they came."""
        return list(self._leaves)

    def __contains__(self, name: str) -> bool:
        path = absolute(name)
        return path in self._leaves or any(self._below(path))

    def get(self, name: str) -> Any:
        """Return the value of a name: that of a leaf, or a dictionary of those below.

        Raises
        ------
        KeyError
            If there is none.
        """
        path = absolute(name)
        if path in self._leaves:
            return json.loads(self._leaves[path])
        tree: dict[str, Any] = {}
        for below in self._below(path):
            *branches, leaf = below[len(path) :].strip("/").split("/")
            node = tree
            for branch in branches:
                node = node.setdefault(branch, {})
            node[leaf] = json.loads(self._leaves[below])
        if not tree:
            raise KeyError(path)
        return tree

    def set(self, name: str, value: Any) -> None:
        """Give a name a value; a dictionary becomes names below it.

        Raises
        ------
        ProtocolError
            If it is too large, or there are too many parameters.
        """
        path = absolute(name)
        check_name(path, "parameter")
        leaves = dict(_leaves(path, value, _DEEPEST))
        n_bytes = sum(map(len, leaves.values()))
        if n_bytes > self._max_bytes:
            raise ProtocolError(f"{path}: {n_bytes} bytes, the limit is {self._max_bytes}")
        if len(self._leaves) + len(leaves) > self._max_parameters:
            raise ProtocolError(f"{path}: there are {self._max_parameters} parameters, the limit")
        if self._n_bytes + n_bytes > _TOTAL_BYTES:
            raise ProtocolError(f"{path}: all parameters take over {_TOTAL_BYTES} bytes, the limit")
        self.delete(path)
        above = path
        while above := above.rpartition("/")[0]:  # a name with others below it is no leaf
            self._forget(above)
        self._leaves.update(leaves)
        self._n_bytes += n_bytes

    def delete(self, name: str) -> None:
        """Forget a name and all below it; one that has no value is no error."""
        path = absolute(name)
        for gone in [path, *self._below(path)]:
            self._forget(gone)

    def _forget(self, path: str) -> None:
        self._n_bytes -= len(self._leaves.pop(path, ""))

    def _below(self, path: str) -> Iterator[str]:
        prefix = path if path.endswith("/") else f"{path}/"
        return (leaf for leaf in self._leaves if leaf.startswith(prefix))


def _leaves(path: str, value: Any, n_levels: int) -> Iterator[tuple[str, str]]:
    """Yield name and JSON text of every value that is no dictionary, or an empty one."""
    if not isinstance(value, dict) or not value:
        yield path, json.dumps(value)
        return
    if not n_levels:
        raise ProtocolError(f"{path[:60]}…: more than {_DEEPEST} levels")
    for name, part in value.items():
        if not name or "/" in name:
            raise ProtocolError(f"{path}: '{name:.40}' is no parameter name")
        yield from _leaves(f"{path.rstrip('/')}/{name}", part, n_levels - 1)
