"""Quicker pictures in the place of the wished one, and what each of them costs."""
