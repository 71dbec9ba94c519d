"""Broken models: one edit of a flawless model for every constraint."""
