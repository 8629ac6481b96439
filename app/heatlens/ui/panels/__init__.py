"""The panels beside the picture, and what their buttons do."""
