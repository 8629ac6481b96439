"""The timeline panel: transport buttons, rows of keys and the curve editor."""
