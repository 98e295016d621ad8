"""Facades as trees of labelled rectangles; see README.md in this folder."""
