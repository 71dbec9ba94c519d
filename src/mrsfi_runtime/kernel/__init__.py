"""The world itself, written once, in a subset of Python that also compiles."""
