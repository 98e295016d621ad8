"""Executors of tasks, and what all runs have on disk."""
