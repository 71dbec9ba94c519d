"""Model to text: loads Ecore models and emits the middleware."""
