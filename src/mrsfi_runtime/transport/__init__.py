"""Moves messages between the two sides of a mission."""
