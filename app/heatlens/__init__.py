"""heatlens: depth of field by simulated diffusion, seen live."""

__version__ = "0.1.0"
