# Generated from mission depot by fault_effects.py.j2.
# Edit inside protected regions only.
"""The effects of the pool's fault types of mode OWN, which the metamodel leaves to regions here."""

from mrsfi_runtime.api import OwnFault, State, kernel


@kernel
def apply(ci: State, inbox: State, fault: OwnFault) -> None:
    """Do nothing: no fault of the pool is of mode OWN."""
