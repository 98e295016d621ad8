"""Models of a run, for any kind of file."""
