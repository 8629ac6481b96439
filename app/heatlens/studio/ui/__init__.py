"""The window: panels, the viewport and the loop that draws them."""
