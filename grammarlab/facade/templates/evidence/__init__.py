"""What the points of an element say about the sizes of a template."""
