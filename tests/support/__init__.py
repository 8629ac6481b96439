"""Helpers shared by the tests: small files, plates, scenes, windows and reference results."""
