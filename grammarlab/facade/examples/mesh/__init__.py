"""Triangles of a building: values, files, cuts along planes, and views from the sides."""
