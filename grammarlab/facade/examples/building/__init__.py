"""Label grids back to meshes: units placed, stitched and closed, the rest stretched."""
