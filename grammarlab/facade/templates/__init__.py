"""Templates that are matched to the elements of a scan, together (paper 001, chapter 5)."""
