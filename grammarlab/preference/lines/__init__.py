"""Points for parts that add up, the sum clipped to 0-100."""
