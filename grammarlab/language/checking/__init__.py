"""Everything that is wrong with a rule file."""
