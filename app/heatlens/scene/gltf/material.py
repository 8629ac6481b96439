"""Materials and pictures of a glTF file.

Sources: Khronos, glTF 2.0 specification, section 3.9; KHR_materials_emissive_strength;
KHR_texture_transform.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.picture_read import read_picture
from heatlens.scene.scene import Color, Material

_BLEND_CUTOFF = 0.5
_STEEPEST = 1e3


@dataclass(frozen=True)
class UvPlace:
    """Which texture coordinates a material uses, and how its pictures are placed in them.

    (u, v) becomes matrix @ (u, v) + offset, where matrix is two rows.
    """

    coordinates: int = 0
    matrix: tuple[tuple[float, float], tuple[float, float]] = ((1.0, 0.0), (0.0, 1.0))
    offset: tuple[float, float] = (0.0, 0.0)

    def placed(self, uvs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return texture coordinates (V, 2) after the transform."""
        moved = uvs @ np.array(self.matrix).T + np.array(self.offset)
        return np.asarray(moved, np.float32)


@dataclass
class GltfMaterials:
    """The materials of a file in its order, and at the end that of meshes without one.

    Raises InputError where a material, or a picture that it uses, is damaged or missing.
    """

    gltf: GltfFile
    materials: list[Material] = field(default_factory=list)
    places: list[UvPlace] = field(default_factory=list)
    images: list[NDArray[np.uint8]] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _found: dict[int, int] = field(default_factory=dict)  # image of the file -> of the scene

    def __post_init__(self) -> None:
        for record in self.gltf.listed("materials"):
            self._add(record)
        self.materials.append(Material("", (1.0, 1.0, 1.0), 1.0, 1.0, 1.0))
        self.places.append(UvPlace())

    def _add(self, record: Record) -> None:
        shine = record.inside("pbrMetallicRoughness")
        textures = (
            (shine, "baseColorTexture"),
            (shine, "metallicRoughnessTexture"),
            (record, "emissiveTexture"),
        )
        base, rough, emission = (self._map(owner, name) for owner, name in textures)
        place = self._place(owner.inside(name) for owner, name in textures)
        bumps, occlusion = record.inside("normalTexture"), record.inside("occlusionTexture")
        if not any(owner.inside(name).has("index") for owner, name in textures):
            place = _uv_place(bumps)
        alpha, cutoff = self._alpha(record, shine.row("baseColorFactor", (1, 1, 1, 1))[3])
        material = Material(
            name=record.text("name"),
            base_color=_color(shine.row("baseColorFactor", (1, 1, 1, 1))),
            base_alpha=alpha,
            metallic=_share(shine, "metallicFactor"),
            roughness=_share(shine, "roughnessFactor"),
            emission=_emission(record),
            alpha_cutoff=cutoff,
            base_color_map=base,
            metallic_roughness_map=rough,
            emission_map=emission,
            normal_map=self._map_alike(record, "normalTexture", place),
            normal_scale=_steepness(bumps),
            occlusion_map=self._map_alike(record, "occlusionTexture", place),
            occlusion=_share(occlusion, "strength"),
        )
        self.materials.append(material)
        self.places.append(place)

    def _alpha(self, record: Record, factor: float) -> tuple[float, float]:
        """Return the factor of the base colour's alpha, and the cutoff below which is a hole."""
        mode = record.text("alphaMode", "OPAQUE")
        if mode == "OPAQUE":
            return 1.0, 0.0
        if mode == "MASK":
            return factor, record.number("alphaCutoff", 0.5)
        if mode != "BLEND":
            record.refuse(f"{mode[:20]!r} is not an alpha mode of glTF")
        self.notes["See-through materials are cut out where they are less than half opaque."] = None
        return factor, _BLEND_CUTOFF

    def _map(self, owner: Record, name: str) -> int | None:
        """Return the index of a texture's picture among the scene's; None for no picture."""
        textures = self.gltf.listed("textures")
        number = owner.inside(name).index("index", len(textures))
        if number is None:
            return None
        texture, images = textures[number], self.gltf.listed("images")
        webp = texture.inside("extensions", "EXT_texture_webp").index("source", len(images))
        source = texture.index("source", len(images)) if webp is None else webp
        if source is None:
            self.notes["A texture names no picture that is known here, and is left out."] = None
            return None
        if source not in self._found:
            self.images.append(_picture(self.gltf, images[source], self.images))
            self._found[source] = len(self.images) - 1
        return self._found[source]

    def _map_alike(self, record: Record, name: str, place: UvPlace) -> int | None:
        """Return a map only if its coordinates are those of the base colour, else leave it out."""
        if record.inside(name).has("index") and _uv_place(record.inside(name)) != place:
            self.notes["Bumps and occlusion that lie otherwise than the colour are left out."] = (
                None
            )
            return None
        return self._map(record, name)

    def _place(self, infos: Iterable[Record]) -> UvPlace:
        """Return the place of the first texture, which all others are assumed to share."""
        places = list(dict.fromkeys(_uv_place(info) for info in infos if info.has("index")))
        if len(places) > 1:
            self.notes["Textures of one material that lie differently are laid alike."] = None
        return places[0] if places else UvPlace()


def _picture(gltf: GltfFile, record: Record, before: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    view = record.index("bufferView", len(gltf.listed("bufferViews")))
    data = gltf.uri_bytes(record) if view is None else bytes(gltf.view(view))
    what = f"{gltf.path}: {record.entry.place}"
    return read_picture(data, what, before)


def _uv_place(info: Record) -> UvPlace:
    """Return the place; KHR_texture_transform turns clockwise as its v axis runs down."""
    moved = info.inside("extensions", "KHR_texture_transform")
    coordinates = moved.whole("texCoord", info.whole("texCoord", 0))
    angle = moved.number("rotation", 0.0)
    c, s = float(np.cos(angle)), float(np.sin(angle))
    (x, y), (u, v) = moved.row("scale", (1, 1)), moved.row("offset", (0, 0))
    return UvPlace(coordinates, ((c * x, s * y), (-s * x, c * y)), (u, v))


def _steepness(bumps: Record) -> float:
    """Limit a normal map's scale to what float32 can represent."""
    return min(max(bumps.number("scale", 1.0), -_STEEPEST), _STEEPEST)


def _emission(record: Record) -> Color:
    strength = record.inside("extensions", "KHR_materials_emissive_strength")
    factor = strength.number("emissiveStrength", 1.0, least=0.0)
    red, green, blue = _color(record.row("emissiveFactor", (0, 0, 0)))
    return factor * red, factor * green, factor * blue


def _color(values: tuple[float, ...]) -> Color:
    """Return the colour without alpha, and not less than black."""
    red, green, blue = (max(value, 0.0) for value in values[:3])
    return red, green, blue


def _share(record: Record, name: str) -> float:
    return min(record.number(name, 1.0, least=0.0), 1.0)
