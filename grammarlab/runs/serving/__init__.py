"""Local pages: the server, its windows, and their requests."""
