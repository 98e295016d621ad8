"""Worker processes of a session: they learn, draw and write files."""
