"""Mattes of objects in a plate: Cryptomatte, channels of ids, and plain mattes."""
