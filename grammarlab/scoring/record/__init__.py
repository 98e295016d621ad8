"""Record of a session: events in a file."""
