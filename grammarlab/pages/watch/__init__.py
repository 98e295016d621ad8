"""The page beside an editor: a rule file as a model that follows every save."""
