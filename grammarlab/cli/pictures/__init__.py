"""Pictures drawn by commands."""
