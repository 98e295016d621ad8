"""Who draws: rays against triangles, or OpenGL."""
