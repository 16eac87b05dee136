"""One-to-one maps between surfaces of two handles or more, through the hyperbolic plane."""
