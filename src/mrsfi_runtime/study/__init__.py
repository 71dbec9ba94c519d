"""Comparison of search algorithms over many seeds: runs, rank tests, figures, folder."""
