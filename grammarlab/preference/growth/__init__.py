"""Trees that divide designs by what their columns explain of scores."""
