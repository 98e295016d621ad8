"""Runs that evaluate methods of learning."""
