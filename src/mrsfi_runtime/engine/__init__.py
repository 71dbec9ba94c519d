"""Evaluates fault specifications."""
