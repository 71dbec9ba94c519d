"""Evaluates on the workers of a dask cluster, on this machine or on others."""
