"""The judge: one number, in nats, by which explanations of scores are compared."""
