"""Triangles of a building: as a value, from files and to files, cut along planes, seen from its sides."""
