"""From a preference to a grammar: densities over derivation trees, and the stochastic grammars that sample them."""
