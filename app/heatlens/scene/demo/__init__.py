"""The scene that is built in."""
