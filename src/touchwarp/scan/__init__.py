"""From a scan to a scene: repair, remeshing, alignment, the tabletop, primitives, a first draft."""
