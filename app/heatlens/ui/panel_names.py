"""The panels there are, as they are called on their tabs and in the menu."""

PANELS = ("Lens", "Look", "Plate", "Scene", "Export", "Marks", "Speed", "Timeline")
