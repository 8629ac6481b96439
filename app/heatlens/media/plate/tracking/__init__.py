"""Follow a surface of a plate through the frames of a sequence, by its colors and its depth."""
