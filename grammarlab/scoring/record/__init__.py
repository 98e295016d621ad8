"""What happened in a session, as events in a file."""
