"""The picture in its window, and the legend over it."""
