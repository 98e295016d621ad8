"""Annotations and buildings of other programs as labelled boxes, and boxes as facades."""
