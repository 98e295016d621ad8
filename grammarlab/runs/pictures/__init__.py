"""Pictures of many models on one page."""
