"""Files of elements: documents of points, scans, meshes; docs/facade-scans.md describes them."""
