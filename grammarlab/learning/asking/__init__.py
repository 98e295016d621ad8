"""Choice of the designs to ask about, round after round, and when to stop."""
