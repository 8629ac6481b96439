"""The viewport and everything drawn over the picture."""
