"""One-to-one maps between closed surfaces, through the sphere or the flat torus."""
