"""The public names of mrsfi, for scripts, notebooks and tests.

A script does the same as the command line in as few lines::

    import mrsfi

    uuv = mrsfi.load("uuv_sampling")
    flight = uuv.fly([uuv.timed("f9", 100, 400)])
    campaign = uuv.evolve("a", generations=5)
    print(campaign.weaknesses[0].faults)

Every error that a user can correct is a ``MrsfiError``. Modules are imported when they are used.
"""

from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mrsfi.campaign import Campaign
    from mrsfi.flight import Flight
    from mrsfi.mission import Mission, load
    from mrsfi.models import write_models
    from mrsfi_runtime.errors import MrsfiError
    from mrsfi_runtime.model.faults import Specification, TimedFault
    from mrsfi_runtime.model.mission import Outcome

__all__ = [
    "Campaign",
    "Flight",
    "Mission",
    "MrsfiError",
    "Outcome",
    "Specification",
    "TimedFault",
    "load",
    "write_models",
]

_PLACES = MappingProxyType(
    {
        "Campaign": "mrsfi.campaign",
        "Flight": "mrsfi.flight",
        "Mission": "mrsfi.mission",
        "MrsfiError": "mrsfi_runtime.errors",
        "Outcome": "mrsfi_runtime.model.mission",
        "Specification": "mrsfi_runtime.model.faults",
        "TimedFault": "mrsfi_runtime.model.faults",
        "load": "mrsfi.mission",
        "write_models": "mrsfi.models",
    }
)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _PLACES:
        from mrsfi_runtime.errors import expected  # noqa: PLC0415 - as this module says

        raise AttributeError(f"module 'mrsfi' has no attribute '{name}'; {expected(name, __all__)}")
    return getattr(import_module(_PLACES[name]), name)
