"""Constraints beyond the metamodel: what a model must keep in order to make sense."""
