"""Reading meshes from USD, in a process of its own."""
