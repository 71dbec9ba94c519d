"""Read files into nodes that know their line, and find the other files of a model."""
