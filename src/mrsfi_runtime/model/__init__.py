"""Immutable vocabulary: missions, goals and tasks, fault types, faults and timed faults."""
