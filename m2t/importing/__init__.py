"""Bring models that were published for the paper's prototype into mission folders."""
