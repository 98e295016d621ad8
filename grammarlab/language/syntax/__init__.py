"""Syntax tree of a rule file, and its text."""
