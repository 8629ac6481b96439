"""Read the pictures of a glTF file, and their placement on surfaces.

A missing or damaged picture is left out with a note. Sources: Khronos, glTF 2.0 specification,
section 3.8; EXT_texture_webp; KHR_texture_basisu; KHR_texture_transform.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError, MissingPackageError
from heatlens.media.scene.gltf.compressed import KTX2_HEAD, decode_ktx2
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.material import MapPlace, Wrap
from heatlens.media.scene.picture_read import read_picture

Pixels = NDArray[np.uint8]
# Extensions that name another picture, the best known first.
_SOURCES = ("KHR_texture_basisu", "EXT_texture_webp")
_NO_PICTURE = -1  # the key in `errors` for textures without a picture
_ERRORS_MOST = 3  # errors that are reported in full
_WRAPS = ("wrapS", "wrapT")
_REPEAT = 10497  # this and the numbers below are OpenGL's
_WRAP_KINDS = {_REPEAT: Wrap.REPEAT, 33071: Wrap.CLAMP, 33648: Wrap.MIRROR}


@dataclass
class GltfTextures:
    """Reads each picture of a file once, when a material first uses it.

    images  the pictures that were read, (H, W, 4)
    errors  the error for each picture of the file that could not be read, by its index there
    """

    gltf: GltfFile
    images: list[Pixels] = field(default_factory=list)
    errors: dict[int, str] = field(default_factory=dict)
    _image_numbers: dict[int, int] = field(
        default_factory=dict
    )  # image of the file -> of the scene

    def map_number(self, owner: Record, name: str) -> int | None:
        """Return the index in `self.images` of the picture of a texture; None for no picture."""
        number = self.gltf.index(owner.object_at(name), "index", "textures")
        return (
            None if number is None else self._image_number(self.gltf.top_level("textures")[number])
        )

    def placement(self, info: Record) -> MapPlace | None:
        """Return the placement of a texture's picture on a surface; None for no picture."""
        number = self.gltf.index(info, "index", "textures")
        if number is None:
            return None
        sampler = self.gltf.index(self.gltf.top_level("textures")[number], "sampler", "samplers")
        sampler_record = None if sampler is None else self.gltf.top_level("samplers")[sampler]
        wrap_codes = (
            []
            if sampler_record is None
            else [sampler_record.whole_number(name, _REPEAT) for name in _WRAPS]
        )
        wrap_u, wrap_v = (
            _WRAP_KINDS.get(code, Wrap.REPEAT)
            for code in wrap_codes or (_REPEAT,) * 2  # without a sampler
        )
        return _read_placement(info, (wrap_u, wrap_v))

    def _image_number(self, texture: Record) -> int | None:
        """Return the index in `self.images` of a texture's picture; None for no picture.

        The picture is read when it is first used. `source` is its index in the file.
        """
        file_images = self.gltf.top_level("images")
        records = [*(texture.object_at("extensions", name) for name in _SOURCES), texture]
        sources = [record.index("source", len(file_images)) for record in records]
        source = next((index for index in sources if index is not None), None)
        if source is None:
            self.errors[_NO_PICTURE] = "a texture names no picture of a known kind"
        if source is None or source in self.errors:
            return None
        if source not in self._image_numbers:
            self._read_image(source, file_images[source])
        return self._image_numbers.get(source)

    def _read_image(self, source: int, record: Record) -> None:
        """Read picture `source` of the file, or store the error if that fails."""
        try:
            self._image_numbers[source] = self.add(_decode_picture(self.gltf, record, self.images))
        except MissingPackageError:
            raise
        except InputError as error:
            self.errors[source] = str(error).removeprefix(f"{self.gltf.path}: ").rstrip(".")

    def add(self, pixels: Pixels) -> int:
        """Keep a picture (H, W, 4) and return its index in `self.images`."""
        self.images.append(pixels)
        return len(self.images) - 1

    @property
    def notes(self) -> dict[str, None]:
        """A sentence on all pictures that are left out, if any."""
        if not self.errors:
            return {}
        errors = list(self.errors.values())
        more_words = (
            f"; and {len(errors) - _ERRORS_MOST} more" if len(errors) > _ERRORS_MOST else ""
        )
        count = "1 picture is" if len(errors) == 1 else f"{len(errors)} pictures are"
        return {f"{count} left out: {'; '.join(errors[:_ERRORS_MOST])}{more_words}.": None}


def _decode_picture(gltf: GltfFile, record: Record, earlier_pictures: list[Pixels]) -> Pixels:
    """Return a picture (H, W, 4) from a buffer view or a file.

    The size of earlier pictures counts towards the limit of all pictures.
    """
    view = gltf.index(record, "bufferView", "bufferViews")
    data = gltf.uri_bytes(record) if view is None else bytes(gltf.view(view))
    label = f"{gltf.path}: {record.entry.place}"
    return (
        decode_ktx2(data, label)
        if data.startswith(KTX2_HEAD)
        else read_picture(data, label, earlier_pictures)
    )


def _read_placement(info: Record, wraps: tuple[Wrap, Wrap]) -> MapPlace:
    """Return the placement of a texture; `wraps` says how it continues along u and v.

    KHR_texture_transform rotates clockwise, because its v axis runs down.
    """
    transform = info.object_at("extensions", "KHR_texture_transform")
    coordinates = transform.whole_number("texCoord", info.whole_number("texCoord", 0))
    angle = transform.number("rotation", 0.0)
    c, s = float(np.cos(angle)), float(np.sin(angle))
    (x, y), (u, v) = transform.row("scale", (1, 1)), transform.row("offset", (0, 0))
    return MapPlace(coordinates, ((c * x, s * y), (-s * x, c * y)), (u, v), wraps)
