"""Light: surfaces, ground, edges and the look of all pictures."""
