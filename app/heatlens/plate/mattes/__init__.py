"""Mattes of things in a plate: Cryptomatte, channels of ids, and plain mattes."""
