"""Light, surfaces and rays."""
