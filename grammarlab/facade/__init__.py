"""Facades: rectangles within rectangles that are read, edited and turned into grammars."""
