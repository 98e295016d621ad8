"""Cities: what stands on each parcel of a map, stable, in place, and the densities of zones learned from answers."""
