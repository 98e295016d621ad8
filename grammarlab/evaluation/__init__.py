"""Evaluation of learning: scenarios, simulated persons, divergences."""
