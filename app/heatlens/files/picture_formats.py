"""Which files are pictures that are read here besides EXR, by the ends of their names."""

from pathlib import Path

PICTURES_READ = (
    *(".png", ".jpg", ".jpeg", ".tif", ".tiff", ".heic", ".heif", ".webp", ".bmp", ".tga"),
    *(".pfm", ".npy"),
)


def is_picture(path: Path) -> bool:
    """Return whether a name is that of a readable picture other than an EXR."""
    return path.suffix.lower() in PICTURES_READ
