"""Many polygon meshes as one value."""
