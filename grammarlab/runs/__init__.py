"""Runs: from a request to files; see README.md in this folder."""
