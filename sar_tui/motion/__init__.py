"""Movement science, pure numpy: reaches found in a sensor's samples, and what is measured of them."""
