"""The loop: scores, rows, a preference, questions, a target density, a grammar. See README.md in this folder."""
