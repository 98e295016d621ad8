"""From a learned preference to a file that samples its density."""
