"""Write models byte for byte as Eclipse EMF does."""
