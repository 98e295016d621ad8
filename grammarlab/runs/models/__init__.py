"""Models of a file as a run makes them, whatever kind of file it is."""
