"""Compiles the kernel and the regions of a mission, and evaluates a generation in one call."""
