"""Static Python classes of the metamodels; ``python -m m2t.classes`` generates them."""
