"""Elements of facades from scans and meshes."""
