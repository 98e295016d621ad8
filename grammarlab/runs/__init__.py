"""Whole runs: from the name of a grammar to files and pictures on disk, repeatable and resumable."""
