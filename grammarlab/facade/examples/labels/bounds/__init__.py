"""Lower bounds of the energy: strips, chains and prices for their agreement."""
