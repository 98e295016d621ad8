"""Designs: they have addresses, can be made again, and are described by numbers."""
