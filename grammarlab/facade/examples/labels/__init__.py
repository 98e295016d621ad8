"""Labels chosen so that every window of a grid looks like one of its examples."""
