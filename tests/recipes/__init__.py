"""The recipes of the README's "Extend", performed in copies of the tree and flown."""
