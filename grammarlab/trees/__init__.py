"""Weber & Penn trees: species as files, skeletons as columns, and their geometry."""
