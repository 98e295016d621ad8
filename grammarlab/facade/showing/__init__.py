"""Facades as pictures, scenes and SVG."""
