"""Describe an export for several machines; programs that schedule such work run it."""
