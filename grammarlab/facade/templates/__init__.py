"""Templates that are matched jointly to the elements of a scan (paper 001, chapter 5)."""
