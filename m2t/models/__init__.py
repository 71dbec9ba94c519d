"""Models as files: read, checked, changed, written."""
