"""Which files are pictures that are read here besides EXR, by the ends of their names."""

from pathlib import Path

PICTURES_READ = (
    *(".png", ".jpg", ".jpeg", ".tif", ".tiff", ".heic", ".heif", ".webp", ".bmp", ".tga"),
    *(".pfm", ".npy"),
)


def is_picture(path: Path) -> bool:
    """Whether a name is that of a picture that is read here, and no EXR."""
    return path.suffix.lower() in PICTURES_READ
