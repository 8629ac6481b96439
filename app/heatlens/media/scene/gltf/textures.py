"""Read the pictures of a glTF file, and their placement on surfaces.

A missing or damaged picture is left out with a note. Sources: Khronos, glTF 2.0 specification,
section 3.8; EXT_texture_webp; KHR_texture_basisu; KHR_texture_transform.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError, MissingPackageError
from heatlens.media.scene.gltf.compressed import KTX2_HEAD, ktx2_pixels
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.picture_read import read_picture
from heatlens.media.scene.scene import MapPlace, Wrap

Pixels = NDArray[np.uint8]
_SOURCES = (
    "KHR_texture_basisu",
    "EXT_texture_webp",
)  # extensions that name another picture, the best known first
_NAMED_MOST = 3
_WRAPS = ("wrapS", "wrapT")
_REPEAT = 10497
_WRAP_KINDS = {_REPEAT: Wrap.REPEAT, 33071: Wrap.CLAMP, 33648: Wrap.MIRROR}


@dataclass
class GltfTextures:
    """Reads each picture of a file once, when a material first uses it.

    images   the pictures that were read, (H, W, 4)
    without  the error for each picture that could not be read
    """

    gltf: GltfFile
    images: list[Pixels] = field(default_factory=list)
    without: dict[int, str] = field(default_factory=dict)
    _found: dict[int, int] = field(default_factory=dict)  # image of the file -> of the scene

    def map(self, owner: Record, name: str) -> int | None:
        """Return the index in `images` of the picture of a texture; None for no picture."""
        number = self.gltf.index(owner.inside(name), "index", "textures")
        return None if number is None else self._image(self.gltf.listed("textures")[number])

    def place(self, info: Record) -> MapPlace | None:
        """Return the placement of a texture's picture on a surface; None for no picture."""
        number = self.gltf.index(info, "index", "textures")
        if number is None:
            return None
        sampler = self.gltf.index(self.gltf.listed("textures")[number], "sampler", "samplers")
        wrap = None if sampler is None else self.gltf.listed("samplers")[sampler]
        words = [] if wrap is None else [wrap.whole(name, _REPEAT) for name in _WRAPS]
        across, down = (_WRAP_KINDS.get(word, Wrap.REPEAT) for word in words or (_REPEAT,) * 2)
        return _map_place(info, (across, down))

    def _image(self, texture: Record) -> int | None:
        images = self.gltf.listed("images")
        named = [texture.inside("extensions", name) for name in _SOURCES]
        sources = [record.index("source", len(images)) for record in (*named, texture)]
        source = next((index for index in sources if index is not None), None)
        if source is None:
            self.without[-1] = "a texture names no picture of a known kind"
        if source is None or source in self.without:
            return None
        if source not in self._found:
            self._read(source, images[source])
        return self._found.get(source)

    def _read(self, source: int, record: Record) -> None:
        try:
            self._found[source] = self.add(_picture(self.gltf, record, self.images))
        except MissingPackageError:
            raise
        except InputError as error:
            self.without[source] = str(error).removeprefix(f"{self.gltf.path}: ").rstrip(".")

    def add(self, pixels: Pixels) -> int:
        """Keep a picture (H, W, 4) and return its index in `images`."""
        self.images.append(pixels)
        return len(self.images) - 1

    @property
    def notes(self) -> dict[str, None]:
        """A sentence on all pictures that are left out, if any."""
        if not self.without:
            return {}
        words = list(self.without.values())
        more = f"; and {len(words) - _NAMED_MOST} more" if len(words) > _NAMED_MOST else ""
        count = "1 picture is" if len(words) == 1 else f"{len(words)} pictures are"
        return {f"{count} left out: {'; '.join(words[:_NAMED_MOST])}{more}.": None}


def _picture(gltf: GltfFile, record: Record, before: list[Pixels]) -> Pixels:
    view = gltf.index(record, "bufferView", "bufferViews")
    data = gltf.uri_bytes(record) if view is None else bytes(gltf.view(view))
    what = f"{gltf.path}: {record.entry.place}"
    return (
        ktx2_pixels(data, what) if data.startswith(KTX2_HEAD) else read_picture(data, what, before)
    )


def _map_place(info: Record, wraps: tuple[Wrap, Wrap]) -> MapPlace:
    """Return the placement; KHR_texture_transform rotates clockwise, as its v axis runs down."""
    moved = info.inside("extensions", "KHR_texture_transform")
    coordinates = moved.whole("texCoord", info.whole("texCoord", 0))
    angle = moved.number("rotation", 0.0)
    c, s = float(np.cos(angle)), float(np.sin(angle))
    (x, y), (u, v) = moved.row("scale", (1, 1)), moved.row("offset", (0, 0))
    return MapPlace(coordinates, ((c * x, s * y), (-s * x, c * y)), (u, v), wraps)
