"""The docked panels beside the picture."""
