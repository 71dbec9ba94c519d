"""The two sides of a mission over a transport, and the lock-step that joins them."""
