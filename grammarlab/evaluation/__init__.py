"""Scenarios, simulated persons and learning curves."""
