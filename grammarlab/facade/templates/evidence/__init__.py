"""Evidence of the points of an element for the sizes of a template."""
