"""Lower bounds of the energy: strips, chains and the prices that they agree on."""
