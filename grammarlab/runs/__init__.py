"""Runs: from a request to files and pictures on disk, repeatable and resumable; see README.md in this folder."""
