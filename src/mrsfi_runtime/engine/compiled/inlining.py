"""Compiles functions that are only ever part of another one, without machine code of their own.

Numba optimises every function with all that it calls, and writes machine code for it. Here they
are kept as they were lowered, and optimised once, where they end up. That takes some two fifths of
compilation away.
"""

from collections.abc import Iterator
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.runtime.nrt import rtsys
from numba.extending import register_jitable

from mrsfi_runtime.engine.compiled.likeness import Checked


class Inlined(Checked):
    """Numba's pipeline, for ``pipeline_class`` of functions that others call."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)  # type: ignore[no-untyped-call]
        codegen = self.state.targetctx.codegen()
        self.state.library = _Library(codegen, "inlined")  # type: ignore[no-untyped-call]


class _Library(JITCodeLibrary):
    """A function's code, to be linked into what calls it."""

    def finalize(self) -> None:
        """Leave the code as it is."""
        self._final_module.verify()
        self._finalized = True

    def get_pointer_to_function(self, _: str) -> int:
        """Return the address of nothing."""
        self.linked()
        return 0

    @property
    def codegen(self) -> "_NoEnvironments":
        """What sets environments: there is no machine code yet that could have one."""
        return _NoEnvironments()

    def linked(self) -> Any:
        """Return the code without that of what it calls."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return self._final_module

    def reached(self) -> Iterator[Any]:
        """Yield the libraries that this links."""
        return iter(self._linking_libraries)

    def whole(self) -> Any:
        """Return the code with that of all functions that it calls, however deep."""
        return self._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            module = self.linked().clone()
            for library in sorted(_closure(self)[1:], key=_rank):
                module.link_in(_code(library), preserve=True)
            for function in module.functions:
                if not function.is_declaration and function.linkage.name == "external":
                    function.linkage = "linkonce_odr"
            self._shared_module = module
        return self._shared_module


def _closure(first: _Library) -> list[Any]:
    """Return a library and all that it reaches, each once."""
    found: list[Any] = [first]
    for library in found:
        for each in library.reached() if isinstance(library, _Library) else ():
            if each not in found:
                found.append(each)
    return found


def _rank(library: Any) -> int:
    """Return when to link: of numba's own code only what is called by then is taken."""
    return 2 if library is rtsys.library else not isinstance(library, _Library)


def _code(library: Any) -> Any:
    if isinstance(library, _Library):
        return library.linked()
    return library._get_module_for_linking()  # noqa: SLF001 - numba's own libraries ask each other


class _NoEnvironments:
    def set_env(self, _name: str, _environment: object) -> None:
        """Leave it to ``bind``."""


jitable = register_jitable(boundscheck=True, no_cfunc_wrapper=True, pipeline_class=Inlined)
"""Lets compiled code call a function, which stays as it is."""
