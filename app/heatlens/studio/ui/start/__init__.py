"""The layout and drawing of the start screen."""
