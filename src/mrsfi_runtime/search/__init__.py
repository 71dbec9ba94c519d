"""Evolves fault specifications; the only package that uses DEAP."""
