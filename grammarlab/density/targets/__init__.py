"""Target densities, and rejection sampling from them."""
