"""Designs of layers: values, patterns, and their text."""
