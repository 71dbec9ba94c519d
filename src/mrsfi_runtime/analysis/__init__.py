"""Reads campaign folders: fronts, patterns, effects, figures and the report."""
