"""What a person may like: one language of quantities of designs, each with a price."""
