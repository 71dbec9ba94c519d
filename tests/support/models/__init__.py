"""Models to test with: copies, models of other shapes, and models drawn at random."""
