"""A hand on the ring: focus, iris and length as a camera or a controller sends them live."""
