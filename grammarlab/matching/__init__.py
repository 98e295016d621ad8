"""Templates matched to the elements of scanned facades."""
