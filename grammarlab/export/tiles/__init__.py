"""3D Tiles 1.1: cities as GLB files of several levels of detail, with instances, ids, and their place on the earth."""
