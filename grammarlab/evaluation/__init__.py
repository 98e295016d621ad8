"""How well preferences and grammars are learned: scenarios, a simulated person, divergences."""
