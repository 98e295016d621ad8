"""Executors and worker processes for the tasks of a run."""
