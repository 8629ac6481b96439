"""Reading glTF."""
