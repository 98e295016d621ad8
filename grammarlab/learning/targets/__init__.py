"""From what was learned to a file that samples it."""
