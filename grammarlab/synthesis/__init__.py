"""New facades and buildings from one example."""
