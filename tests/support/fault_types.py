"""The fault types of the metamodel, for tests that make faults without a model."""

from m2t.metamodels import load_metamodels

FAULT_TYPES = load_metamodels().fault_types
