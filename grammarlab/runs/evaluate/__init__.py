"""Evaluation on disk: methods, seeds and scenarios, with curves, pictures and pages."""
