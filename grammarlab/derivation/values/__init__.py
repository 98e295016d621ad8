"""Values that shapes refer to by number: frames, materials, strings."""
