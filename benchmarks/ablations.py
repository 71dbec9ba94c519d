r"""``guided`` without one of its parts each: what every part is worth.

Algorithms for ``mrsfi compare``, named ``ablations:NAME`` with this folder on the path of Python.
They search with seeds 201, 202 … where the comparison says 1, 2 …, which nothing was tuned on;
``whole`` is ``guided`` itself with those seeds. For example, from the project's folder::

    PYTHONPATH=benchmarks mrsfi compare uuv_sampling --out runs/ablations-uuv_sampling-a \
        --algorithms ablations:whole,ablations:no_crossover,ablations:one_step
"""

import importlib.util
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search import guided
from mrsfi_runtime.search.individuals import Individual
from mrsfi_runtime.search.loop import Algorithm
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.steps import STEPS, filled, jumped, widened

_FIRST_SEED = 200

Search = Callable[[SearchSpace, CampaignSettings], Algorithm]


def _copy(**constants: object) -> Any:
    """Return a copy of the module of ``guided``, with other constants."""
    spec = importlib.util.spec_from_file_location("guided_copy", str(guided.__file__))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for name, value in constants.items():
        assert hasattr(module, name), name
        setattr(module, name, value)
    return module


def _search(module: Any) -> Search:
    def search(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
        moved = replace(settings, seed=settings.seed + _FIRST_SEED)
        algorithm: Algorithm = module.guided(space, moved)
        return algorithm

    return search


def _blind(module: Any, method: str) -> Any:
    """Let a method of the search act as if there were no front."""
    guide = vars(module)["_Guide"]
    known = vars(guide)[method]

    def changed(self: Any, individuals: Any) -> Individual:
        front, self._front = self._front, {}
        try:
            found: Individual = known(self, individuals)
        finally:
            self._front = front
        return found

    setattr(guide, method, changed)
    return module


def _from_long_windows(module: Any) -> Any:
    """Let the search begin with long windows at landmarks, also where it keeps a front."""

    def new(self: Any) -> Individual:
        return Individual(filled(self._space, (), self._n_faults, self._rng))

    setattr(vars(module)["_Guide"], "_new", new)  # noqa: B010 - the class is private
    return module


whole = _search(_copy())
no_crossover = _search(_copy(_CROSSOVER=0.0))
one_step = _search(_copy(_MORE_STEPS=0.0))
no_landmarks = _search(_copy(STEPS=tuple(step for step in STEPS if step is not jumped)))
no_filling = _search(_copy(_HALF=0.0))
no_archive = _search(_copy(_ARCHIVE_SHARE=0.0))
no_credit = _search(_copy(_LEAST=1.0))
twins = _search(_copy(_TWINS=10**9))
last_four = _search(
    _copy(
        _HALF=0.0,
        _ARCHIVE_SHARE=0.0,
        _LEAST=1.0,
        _TWINS=10**9,
        STEPS=tuple(step for step in STEPS if step is not widened),
    )
)
"""Without all of the four before, and without the step that stretches windows."""

no_front_parents = _search(_blind(_copy(), "_parent"))
no_front_donors = _search(_blind(_copy(), "_donor"))
long_beginning = _search(_from_long_windows(_copy()))
no_front = _search(_blind(_blind(_from_long_windows(_copy()), "_parent"), "_donor"))
"""Without all three of what few goals have of their own."""
