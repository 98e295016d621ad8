"""Trees that divide designs in cells of one value."""
