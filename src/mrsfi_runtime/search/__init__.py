"""Evolves fault specifications; the only room that knows DEAP."""
