"""A shot to files: frame by frame, begun again where it stopped, never half written."""
