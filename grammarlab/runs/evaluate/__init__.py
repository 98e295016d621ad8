"""Evaluation on disk: many learners, seeds and scenarios, their curves, pictures and pages."""
