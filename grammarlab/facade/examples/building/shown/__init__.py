"""Buildings and walls as pictures."""
