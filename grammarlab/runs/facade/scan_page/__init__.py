"""A page of the elements of a scan: what was matched, and what a person says about it."""
