"""Write models and metamodels byte for byte as Eclipse EMF does."""
