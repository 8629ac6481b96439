"""The built-in demo scene."""
