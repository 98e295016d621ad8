"""Rendering engines: ray casting and OpenGL."""
