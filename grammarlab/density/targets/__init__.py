"""Target densities, and rejection sampling."""
