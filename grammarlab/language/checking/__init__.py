"""Checker of rule files."""
