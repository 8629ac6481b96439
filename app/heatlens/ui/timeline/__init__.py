"""Frames and keys: the playhead, the rows of keys, the curve, playing."""
