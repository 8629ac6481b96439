"""What options are called in other programs, for hints on names that there are not."""

OTHER_NAMES = {
    "aperture": "f-stop",
    "blende": "f-stop",
    "brennweite": "focal-length",
    "fnumber": "f-stop",
    "fstop": "f-stop",
    "iris": "f-stop",
    "camera": "scene-camera",
    "focus": "focus-distance",
    "fokus": "focus-distance",
    "lens": "focal-length",
    "out": "output",
    "resolution": "size",
    "samples": "views",
    "sensor": "sensor-width",
}
