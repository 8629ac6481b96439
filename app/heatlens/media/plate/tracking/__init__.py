"""Follow a surface of a plate through the frames of a sequence, by its colours and its depth."""
