"""What must be known of a tree to count patterns in it: attributes, automata, and what is read."""
