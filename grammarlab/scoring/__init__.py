"""Scoring sessions: a person scores models, and the density is learned from the scores."""
