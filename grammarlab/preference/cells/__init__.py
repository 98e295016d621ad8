"""Trees that divide designs into cells of one value."""
