"""Simple approximations of a preference."""
