"""Variations of facades: grids, other sizes, more or fewer columns and rows."""
