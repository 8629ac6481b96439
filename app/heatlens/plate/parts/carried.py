"""Choose the entries of an input header that are copied to the output."""

from heatlens.plate.exr.exr_write import JOB_ATTRIBUTE
from heatlens.plate.header.channels import Header
from heatlens.plate.parts.picture_parts import PICTURE_FACTS
from heatlens.plate.picture.portrait import FOCUS_POINT

# The writer writes these itself, or they describe parts, channels and layouts of the input alone.
_NOT_CARRIED = {
    *("channels", "compression", "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio"),
    *("type", "tiles", "chunkCount", "name", "version", "preview", "maxSamplesPerPixel"),
    *("multiView", "view", "dwaCompressionLevel", "zipCompressionLevel", "idManifest"),
    *("deepImageState", JOB_ATTRIBUTE, FOCUS_POINT, PICTURE_FACTS),
}


def carried(header: Header) -> dict[str, object]:
    """Return the metadata worth keeping in the output."""
    return {
        name: value
        for name, value in header.items()
        if name not in _NOT_CARRIED and not name.startswith("cryptomatte/")
    }
