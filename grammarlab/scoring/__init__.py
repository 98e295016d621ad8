"""Scoring rounds: a person looks at models and scores them, and the density follows."""
