"""Highlights: pixels brighter than their surroundings are removed and drawn as discs."""
