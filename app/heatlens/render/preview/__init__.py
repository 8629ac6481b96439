"""Faster preview pictures, and their cost."""
