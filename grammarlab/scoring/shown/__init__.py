"""What a page shows: orders of models, and what is known about them."""
