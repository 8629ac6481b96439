"""The timeline as it is drawn: rows of keys, the curve, transport."""
