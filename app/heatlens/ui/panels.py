"""The panels there are, as they are called on their tabs and in the menu."""

PANELS = ("Lens", "Look", "Plate", "Export", "Marks", "Speed", "Timeline")
