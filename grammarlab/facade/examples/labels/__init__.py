"""Choice of labels such that every window of a grid looks like a window of the examples."""
