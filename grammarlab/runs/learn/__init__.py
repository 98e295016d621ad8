"""Runs that learn a grammar."""
