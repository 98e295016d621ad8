"""Checks of rule files."""
