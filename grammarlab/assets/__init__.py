"""Asset files from strangers: their headers are checked before they are read."""
