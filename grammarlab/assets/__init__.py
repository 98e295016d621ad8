"""Files of meshes and images that rules insert."""
