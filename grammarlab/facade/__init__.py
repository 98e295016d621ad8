"""Facades: nested rectangles that are read, edited and turned into grammars."""
