"""Live lens input: focus, iris and focal length sent by a camera or a controller."""
