"""The simulated world, written once, in a subset of Python that also compiles."""
