"""Shown models: their order, and knowledge about them."""
