"""Asset files of strangers: what they claim is checked, then they are read."""
