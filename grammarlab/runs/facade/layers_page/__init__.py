"""The page for a design of layers: dragging its canvas, switching its parts and editing its text."""
