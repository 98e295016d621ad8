"""Shapes cut into slabs, along an axis of the scope or in texture space."""
