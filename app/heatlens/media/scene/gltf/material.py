"""Materials of a glTF file.

Sources: Khronos, glTF 2.0 specification, section 3.9; KHR_materials_emissive_strength,
KHR_materials_unlit, KHR_materials_pbrSpecularGlossiness, KHR_materials_transmission.

Specular colour and glossiness are converted to metalness and roughness. Both models describe a
diffuse colour and a reflection at normal incidence. A reflection that is stronger than that of
glass or paint must come from a metal, which determines the metalness. Source: Khronos,
KHR_materials_pbrSpecularGlossiness and the conversion that its authors published with it.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.textures import GltfTextures
from heatlens.media.scene.scene import Array, Color, MapPlace, Material

_STEEPEST = 1e3
_APART = "Gloss maps with a placement of their own take that of the colour map"
_GLOSSY = "KHR_materials_pbrSpecularGlossiness"
_SETS_MOST = 2
_TOO_MANY_SETS = "Materials with more than two sets of texture coordinates use only two"
_DIELECTRIC = 0.04  # reflectance of non-metals at normal incidence
_LEAST = 1e-6
_LUMA = np.array([0.299, 0.587, 0.114])
_SIDE_MOST_PX, _ROWS_AT_ONCE = 2048, 256

Pixels = NDArray[np.uint8]


@dataclass(frozen=True)
class MapLayout:
    """How the texture coordinates of a mesh are converted for a material's maps.

    sets    the sets of the file that are used, at most two
    shared  the placement that all maps share; the identity if each has its own
    """

    sets: tuple[int, ...] = (0,)
    shared: MapPlace = field(default_factory=MapPlace)


@dataclass
class GltfMaterials:
    """The materials of a file in order, then the default material for meshes without one.

    Raises InputError if a material is damaged.
    """

    gltf: GltfFile
    materials: list[Material] = field(default_factory=list)
    layouts: list[MapLayout] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    textures: GltfTextures = field(init=False)

    def __post_init__(self) -> None:
        self.textures = GltfTextures(self.gltf)
        for record in self.gltf.listed("materials"):
            self._add(record)
        self.materials.append(Material("", (1.0, 1.0, 1.0), 1.0, 1.0, 1.0))
        self.layouts.append(MapLayout())
        self.notes |= self.textures.notes

    def _add(self, record: Record) -> None:
        glossy = record.inside("extensions").has(_GLOSSY)
        base, owners = self._glossy(record) if glossy else self._metallic(record)
        bumps, occlusion = record.inside("normalTexture"), record.inside("occlusionTexture")
        material = replace(
            base,
            name=record.text("name"),
            emission=_emission(record),
            emission_map=self.textures.map(record, "emissiveTexture"),
            normal_map=self.textures.map(record, "normalTexture"),
            normal_scale=_steepness(bumps),
            occlusion_map=self.textures.map(record, "occlusionTexture"),
            occlusion=_share(occlusion, "strength"),
            is_lit=not record.inside("extensions").has("KHR_materials_unlit"),
        )
        of_base, of_shine = owners
        material, of_base = see_through(
            self.textures, record, _with_alpha(record, material), of_base
        )
        infos = (of_base, of_shine, record.inside("emissiveTexture"), bumps, occlusion)
        self._lay(material, list(map(self.textures.place, infos)), record)

    def _metallic(self, record: Record) -> tuple[Material, tuple[Record, Record]]:
        """Return the material of pbrMetallicRoughness, and the records that place its two maps."""
        shine = record.inside("pbrMetallicRoughness")
        factor = shine.row("baseColorFactor", (1, 1, 1, 1))
        names = ("baseColorTexture", "metallicRoughnessTexture")
        base, rough = (self.textures.map(shine, name) for name in names)
        material = Material(
            base_color=_color(factor),
            base_alpha=factor[3],
            metallic=_share(shine, "metallicFactor"),
            roughness=_share(shine, "roughnessFactor"),
            base_color_map=base,
            metallic_roughness_map=rough,
        )
        return material, (shine.inside(names[0]), shine.inside(names[1]))

    def _glossy(self, record: Record) -> tuple[Material, tuple[Record, Record]]:
        """Return the material of KHR_materials_pbrSpecularGlossiness, and its maps' records."""
        glossy = record.inside("extensions", _GLOSSY)
        names = ("diffuseTexture", "specularGlossinessTexture")
        diffuse = np.clip(glossy.row("diffuseFactor", (1, 1, 1, 1)), 0, 1)
        gloss = _share(glossy, "glossinessFactor")
        specular = np.clip((*glossy.row("specularFactor", (1, 1, 1)), gloss), 0, 1)
        maps = [self.textures.map(glossy, name) for name in names]
        places = glossy.inside(names[0]), glossy.inside(names[1])
        if maps == [None, None]:
            metal, color = metal_and_base(diffuse[:3], specular[:3])
            alpha = float(diffuse[3])
            return Material("", _color(tuple(color)), alpha, float(metal), 1 - gloss), places
        pictures = [None if m is None else self.textures.images[m] for m in maps]
        made = converted_pictures((pictures[0], diffuse), (pictures[1], specular))
        base, rough = map(self.textures.add, made)
        material = Material(
            "", (1, 1, 1), 1, 1, 1, base_color_map=base, metallic_roughness_map=rough
        )
        placed = next((place for place in places if place.has("index")), places[0])
        if len({self.textures.place(place) for place in places if place.has("index")}) > 1:
            self.gltf.lose(_APART, record)
        return material, (placed, placed)

    def _lay(self, material: Material, places: list[MapPlace | None], record: Record) -> None:
        """Keep a material with the placements of its maps, in the order of `Material.maps`."""
        used = list(dict.fromkeys(place for place in places if place is not None))
        sets = tuple(sorted({place.coordinates for place in used})) or (0,)
        if len(used) <= 1 and not any(place.is_wrapped for place in used):
            shared = used[0] if used else MapPlace()
            self.layouts.append(MapLayout(sets, shared))
            self.materials.append(material)
            return
        if len(sets) > _SETS_MOST:
            self.gltf.lose(_TOO_MANY_SETS, record)
            sets = sets[:_SETS_MOST]
        numbered = [MapPlace() if place is None else _renumbered(place, sets) for place in places]
        self.layouts.append(MapLayout(sets))
        self.materials.append(replace(material, map_places=tuple(numbered)))


def _renumbered(place: MapPlace, sets: tuple[int, ...]) -> MapPlace:
    number = sets.index(place.coordinates) if place.coordinates in sets else 0
    return replace(place, coordinates=number)


def _with_alpha(record: Record, material: Material) -> Material:
    """Return the material with the cutoff or blending of its alpha mode."""
    mode = record.text("alphaMode", "OPAQUE")
    if mode == "OPAQUE":
        return replace(material, base_alpha=1.0)
    if mode == "MASK":
        return replace(material, alpha_cutoff=record.number("alphaCutoff", 0.5))
    if mode != "BLEND":
        record.refuse(f"{mode[:20]!r} is not an alpha mode of glTF")
    return replace(material, is_blended=True)


def _steepness(bumps: Record) -> float:
    """Return the scale of a normal map, limited to a safe range."""
    return min(max(bumps.number("scale", 1.0), -_STEEPEST), _STEEPEST)


def _emission(record: Record) -> Color:
    strength = record.inside("extensions", "KHR_materials_emissive_strength")
    factor = strength.number("emissiveStrength", 1.0, least=0.0)
    red, green, blue = _color(record.row("emissiveFactor", (0, 0, 0)))
    return factor * red, factor * green, factor * blue


def _color(values: tuple[float, ...]) -> Color:
    """Return the colour without alpha, clamped to 0 or more."""
    red, green, blue = (max(float(value), 0.0) for value in values[:3])
    return red, green, blue


def _share(record: Record, name: str) -> float:
    return min(record.number(name, 1.0, least=0.0), 1.0)


# Share of light that passes straight through clear glass; its two sides reflect the rest.
_CLEAREST = 0.9
_HOLED = "Glass with holes is opaque around them"
_BY_MEAN = "Transmission maps with a placement of their own are replaced by their mean"


def see_through(
    textures: GltfTextures, record: Record, material: Material, of_base: Record
) -> tuple[Material, Record]:
    """Return the material with its transmission, and the record that places its base colour map.

    A transmission map is merged into the alpha of the base colour map.
    """
    entry = record.inside("extensions", "KHR_materials_transmission")
    through = min(entry.number("transmissionFactor", 0.0, least=0.0), 1.0)
    if through and material.alpha_cutoff:
        textures.gltf.lose(_HOLED, record)
    if not through or material.alpha_cutoff:
        return material, of_base
    clear = min(_CLEAREST * through * sum(material.base_color) / 3, _CLEAREST)
    glass = replace(material, is_blended=True)
    info, number = entry.inside("transmissionTexture"), textures.map(entry, "transmissionTexture")
    if number is None:
        return replace(glass, base_alpha=material.base_alpha * (1 - clear)), of_base
    places = textures.place(info), textures.place(of_base)
    if material.base_color_map is not None and places[0] != places[1]:
        textures.gltf.lose(_BY_MEAN, record)
        clear *= float(textures.images[number][..., 0].mean()) / 255
        return replace(glass, base_alpha=material.base_alpha * (1 - clear)), of_base
    made = _clear_picture(textures, material.base_color_map, number, clear)
    return replace(glass, base_color_map=made), info


def _clear_picture(textures: GltfTextures, base: int | None, through: int, clear: float) -> int:
    """Add the picture `base` with alpha reduced by the transmission map; return its index."""
    pictures = [None if base is None else textures.images[base], textures.images[through]]
    size = common_size([picture for picture in pictures if picture is not None])
    color, share = (resized(picture, size) for picture in pictures)
    made = color.copy()
    covered = 1.0 - clear * (share[..., 0] / np.float32(255))
    made[..., 3] = np.round(color[..., 3] * covered).astype(np.uint8)
    return textures.add(made)


def metal_and_base(diffuse: Array, specular: Array) -> tuple[Array, Array]:
    """Return the metallic share (...,) and the base colour (..., 3) of linear colours (..., 3)."""
    strength = 1.0 - specular.max(axis=-1)
    bright, shine = (np.sqrt((colors * colors) @ _LUMA) for colors in (diffuse, specular))
    b = bright * strength / (1 - _DIELECTRIC) + shine - 2 * _DIELECTRIC
    root = np.sqrt(np.maximum(b * b - 4 * _DIELECTRIC * (_DIELECTRIC - shine), 0.0))
    metal = np.clip((root - b) / (2 * _DIELECTRIC), 0.0, 1.0)
    metal = np.where(shine < _DIELECTRIC, 0.0, metal)
    share = metal[..., None]
    matt = diffuse * (strength / (1 - _DIELECTRIC) / np.maximum(1 - metal, _LEAST))[..., None]
    shiny = (specular - _DIELECTRIC * (1 - share)) / np.maximum(share, _LEAST)
    return metal, np.clip(matt + (shiny - matt) * share * share, 0.0, 1.0)


def converted_pictures(
    diffuse: tuple[Pixels | None, Array], specular: tuple[Pixels | None, Array]
) -> tuple[Pixels, Pixels]:
    """Return a base colour picture, and one with roughness in green and metal in blue.

    Each argument is a picture (H, W, 4), None for white, and its factor (4,): the diffuse colour
    and alpha, and the specular colour and glossiness.
    """
    size = common_size([picture for picture, _ in (diffuse, specular) if picture is not None])
    pictures = [resized(picture, size) for picture, _ in (diffuse, specular)]
    base, rough = np.empty((*size[::-1], 4), np.uint8), np.zeros((*size[::-1], 4), np.uint8)
    for row in range(0, size[1], _ROWS_AT_ONCE):
        rows = slice(row, row + _ROWS_AT_ONCE)
        matt, shiny = (
            _linear(picture[rows]) * factor
            for picture, factor in zip(pictures, (diffuse[1], specular[1]), strict=True)
        )
        metal, color = metal_and_base(matt[..., :3], shiny[..., :3])
        base[rows] = _bytes(np.concatenate([_encoded(color), matt[..., 3:]], axis=-1))
        rough[rows, :, 1], rough[rows, :, 2] = _bytes(1 - shiny[..., 3]), _bytes(metal)
    rough[..., 3] = 255
    return base, rough


def common_size(pictures: list[Pixels]) -> tuple[int, int]:
    """Return the largest width and height, within reason."""
    height, width = (max(p.shape[axis] for p in pictures) for axis in (0, 1))
    return min(width, _SIDE_MOST_PX), min(height, _SIDE_MOST_PX)


def resized(picture: Pixels | None, size: tuple[int, int]) -> Pixels:
    """Return a picture (H, W, 4) at a width and height, white for None."""
    if picture is None:
        return np.full((*size[::-1], 4), 255, np.uint8)
    if picture.shape[1::-1] == size:
        return picture
    channels = [Image.fromarray(np.ascontiguousarray(picture[..., i])) for i in range(4)]
    resized = [channel.resize(size, Image.Resampling.BILINEAR) for channel in channels]
    return np.stack([np.asarray(channel) for channel in resized], axis=-1)


def _linear(picture: Pixels) -> Array:
    """Return linear colours with unchanged alpha, from 0 to 1 (IEC 61966-2-1)."""
    shares = picture / 255.0
    colors = shares[..., :3]
    shares[..., :3] = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    return np.asarray(shares, np.float64)


def _encoded(colors: Array) -> Array:
    curve = 1.055 * np.maximum(colors, 0.0) ** (1 / 2.4) - 0.055
    return np.where(colors <= 0.0031308, 12.92 * colors, curve)


def _bytes(shares: Array) -> Pixels:
    return np.asarray(np.round(np.clip(shares, 0, 1) * 255), np.uint8)
