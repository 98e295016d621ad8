"""What a run is asked to make, and whether that can be done."""
