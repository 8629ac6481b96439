"""The file extensions of the pictures that can be read besides EXR."""

from pathlib import Path

PICTURES_READ = (
    *(".png", ".jpg", ".jpeg", ".tif", ".tiff", ".heic", ".heif", ".webp", ".bmp", ".tga"),
    *(".avif", ".pfm", ".npy"),
)


def is_picture(path: Path) -> bool:
    """Return whether the extension is that of a readable picture other than EXR."""
    return path.suffix.lower() in PICTURES_READ
