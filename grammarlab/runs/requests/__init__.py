"""Requests of runs, and their checks."""
