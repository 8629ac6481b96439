"""The start screen: how it is laid out and drawn."""
