"""New buildings from examples of their kind: units, their labels on a grid, other grids of the same labels."""
