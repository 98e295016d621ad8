"""How much light reaches the eye: surfaces, ground, edges and the look of all pictures."""
