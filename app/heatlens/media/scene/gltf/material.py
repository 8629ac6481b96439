"""Materials of a glTF file.

Sources: Khronos, glTF 2.0 specification, section 3.9; KHR_materials_emissive_strength,
KHR_materials_unlit, KHR_materials_pbrSpecularGlossiness, KHR_materials_transmission.

Specular color and glossiness are converted to metalness and roughness. Both models describe a
diffuse color and a reflection at normal incidence. A reflection that is stronger than that of
glass or paint must come from a metal, which determines the metalness. Source: Khronos,
KHR_materials_pbrSpecularGlossiness and the conversion that its authors published with it.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.gloss_pictures import (
    common_size,
    convert_gloss_pictures,
    convert_specular,
    resize_picture,
)
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.textures import GltfTextures
from heatlens.media.scene.material import Color, MapPlace, Material

_STEEPEST = 1e3  # largest scale of a normal map
_PLACEMENT_NOTE = "Gloss maps with a placement of their own take that of the colour map"
_GLOSSY_EXTENSION = "KHR_materials_pbrSpecularGlossiness"
_SETS_MOST = 2
_SETS_NOTE = "Materials with more than two sets of texture coordinates use only two"


@dataclass(frozen=True)
class MapLayout:
    """Which texture coordinates of the file a mesh keeps for the maps of a material.

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
        for record in self.gltf.top_level("materials"):
            self._add_material(record)
        self.materials.append(Material("", (1.0, 1.0, 1.0), 1.0, 1.0, 1.0))
        self.layouts.append(MapLayout())
        self.notes |= self.textures.notes

    def _add_material(self, record: Record) -> None:
        """Read a material with its maps and their placements, and add it."""
        glossy = record.object_at("extensions").has(_GLOSSY_EXTENSION)
        base, map_records = self._read_glossy(record) if glossy else self._read_metallic(record)
        bumps, occlusion = record.object_at("normalTexture"), record.object_at("occlusionTexture")
        material = replace(
            base,
            name=record.text("name"),
            emission=_read_emission(record),
            emission_map=self.textures.map_number(record, "emissiveTexture"),
            normal_map=self.textures.map_number(record, "normalTexture"),
            normal_scale=min(max(bumps.number("scale", 1.0), -_STEEPEST), _STEEPEST),
            occlusion_map=self.textures.map_number(record, "occlusionTexture"),
            occlusion=_read_share(occlusion, "strength"),
            is_lit=not record.object_at("extensions").has("KHR_materials_unlit"),
        )
        base_record, shine_record = map_records
        material, base_record = add_transmission(
            self.textures, record, _apply_alpha_mode(record, material), base_record
        )
        # The placement of a map comes from the record that names it. `add_transmission` may replace
        # the record of the base color map.
        infos = (base_record, shine_record, record.object_at("emissiveTexture"), bumps, occlusion)
        self._store(material, list(map(self.textures.placement, infos)), record)

    def _read_metallic(self, record: Record) -> tuple[Material, tuple[Record, Record]]:
        """Return the material of pbrMetallicRoughness, and the records that place its two maps."""
        shine = record.object_at("pbrMetallicRoughness")
        factor = shine.row("baseColorFactor", (1, 1, 1, 1))
        names = ("baseColorTexture", "metallicRoughnessTexture")
        # The indices of the two maps in the pictures of the file, or None.
        base, rough = (self.textures.map_number(shine, name) for name in names)
        material = Material(
            base_color=_read_color(factor),
            base_alpha=factor[3],
            metallic=_read_share(shine, "metallicFactor"),
            roughness=_read_share(shine, "roughnessFactor"),
            base_color_map=base,
            metallic_roughness_map=rough,
        )
        return material, (shine.object_at(names[0]), shine.object_at(names[1]))

    def _read_glossy(self, record: Record) -> tuple[Material, tuple[Record, Record]]:
        """Return the material of KHR_materials_pbrSpecularGlossiness, and the records of its maps.

        Both of its pictures are converted, and take the placement of the first map.
        """
        glossy = record.object_at("extensions", _GLOSSY_EXTENSION)
        names = ("diffuseTexture", "specularGlossinessTexture")
        diffuse = np.clip(glossy.row("diffuseFactor", (1, 1, 1, 1)), 0, 1)
        gloss = _read_share(glossy, "glossinessFactor")
        specular = np.clip((*glossy.row("specularFactor", (1, 1, 1)), gloss), 0, 1)
        maps = [self.textures.map_number(glossy, name) for name in names]
        map_records = glossy.object_at(names[0]), glossy.object_at(names[1])
        if maps == [None, None]:
            metal, color = convert_specular(diffuse[:3], specular[:3])
            alpha = float(diffuse[3])
            return Material(
                "", _read_color(tuple(color)), alpha, float(metal), 1 - gloss
            ), map_records
        pictures = [None if number is None else self.textures.images[number] for number in maps]
        converted = convert_gloss_pictures((pictures[0], diffuse), (pictures[1], specular))
        # The indices of the converted pictures.
        base, rough = map(self.textures.add, converted)
        material = Material(
            "", (1, 1, 1), 1, 1, 1, base_color_map=base, metallic_roughness_map=rough
        )
        placed_record = next(
            (map_record for map_record in map_records if map_record.has("index")), map_records[0]
        )
        if (
            len(
                {
                    self.textures.placement(map_record)
                    for map_record in map_records
                    if map_record.has("index")
                }
            )
            > 1
        ):
            self.gltf.note_loss(_PLACEMENT_NOTE, record)
        return material, (placed_record, placed_record)

    def _store(self, material: Material, placements: list[MapPlace | None], record: Record) -> None:
        """Store a material with the placements of its maps, in the order of `Material.maps`.

        A placement that all maps share goes into the layout; otherwise each map keeps its own.
        """
        used_placements = list(
            dict.fromkeys(placement for placement in placements if placement is not None)
        )
        sets = tuple(sorted({placement.coordinates for placement in used_placements})) or (0,)
        if len(used_placements) <= 1 and not any(
            placement.is_wrapped for placement in used_placements
        ):
            shared = used_placements[0] if used_placements else MapPlace()
            self.layouts.append(MapLayout(sets, shared))
            self.materials.append(material)
            return
        if len(sets) > _SETS_MOST:
            self.gltf.note_loss(_SETS_NOTE, record)
            sets = sets[:_SETS_MOST]
        renumbered = [
            MapPlace() if placement is None else _renumber_set(placement, sets)
            for placement in placements
        ]
        self.layouts.append(MapLayout(sets))
        self.materials.append(replace(material, map_places=tuple(renumbered)))


def _renumber_set(place: MapPlace, sets: tuple[int, ...]) -> MapPlace:
    """Return the placement with its set of texture coordinates as an index into `sets`, or 0."""
    number = sets.index(place.coordinates) if place.coordinates in sets else 0
    return replace(place, coordinates=number)


def _apply_alpha_mode(record: Record, material: Material) -> Material:
    """Return the material with the cutoff or blending of its alpha mode."""
    mode = record.text("alphaMode", "OPAQUE")
    if mode == "OPAQUE":
        return replace(material, base_alpha=1.0)
    if mode == "MASK":
        return replace(material, alpha_cutoff=record.number("alphaCutoff", 0.5))
    if mode != "BLEND":
        record.refuse(f"{mode[:20]!r} is not an alpha mode of glTF")
    return replace(material, is_blended=True)


def _read_emission(record: Record) -> Color:
    """Return the emitted light of a material in red, green and blue."""
    strength = record.object_at("extensions", "KHR_materials_emissive_strength")
    factor = strength.number("emissiveStrength", 1.0, least=0.0)
    red, green, blue = _read_color(record.row("emissiveFactor", (0, 0, 0)))
    return factor * red, factor * green, factor * blue


def _read_color(values: tuple[float, ...]) -> Color:
    """Return the color without alpha, clamped to 0 or more."""
    red, green, blue = (max(float(value), 0.0) for value in values[:3])
    return red, green, blue


def _read_share(record: Record, name: str) -> float:
    """Return a number of 0 to 1, by default 1."""
    return min(record.number(name, 1.0, least=0.0), 1.0)


# Share of light that passes straight through clear glass; its two sides reflect the rest.
_CLEAR_MOST = 0.9
_HOLES_NOTE = "Glass with holes is opaque around them"
_MEAN_NOTE = "Transmission maps with a placement of their own are replaced by their mean"


def add_transmission(
    textures: GltfTextures, record: Record, material: Material, base_record: Record
) -> tuple[Material, Record]:
    """Return the material with its transmission, and the record that places its base color map.

    A transmission map is merged into the alpha of the base color map.
    """
    entry = record.object_at("extensions", "KHR_materials_transmission")
    transmission = min(entry.number("transmissionFactor", 0.0, least=0.0), 1.0)
    if transmission and material.alpha_cutoff:
        textures.gltf.note_loss(_HOLES_NOTE, record)
    if not transmission or material.alpha_cutoff:
        return material, base_record
    clear_share = min(_CLEAR_MOST * transmission * sum(material.base_color) / 3, _CLEAR_MOST)
    glass = replace(material, is_blended=True)
    info = entry.object_at("transmissionTexture")
    number = textures.map_number(entry, "transmissionTexture")
    if number is None:
        return replace(glass, base_alpha=material.base_alpha * (1 - clear_share)), base_record
    placements = textures.placement(info), textures.placement(base_record)
    if material.base_color_map is not None and placements[0] != placements[1]:
        textures.gltf.note_loss(_MEAN_NOTE, record)
        clear_share *= float(textures.images[number][..., 0].mean()) / 255
        return replace(glass, base_alpha=material.base_alpha * (1 - clear_share)), base_record
    picture_number = _merge_transmission(textures, material.base_color_map, number, clear_share)
    return replace(glass, base_color_map=picture_number), info


def _merge_transmission(
    textures: GltfTextures, base: int | None, transmission: int, clear_share: float
) -> int:
    """Add the picture `base` with alpha reduced by the transmission map; return its index."""
    pictures = [None if base is None else textures.images[base], textures.images[transmission]]
    size = common_size([picture for picture in pictures if picture is not None])
    color, share = (resize_picture(picture, size) for picture in pictures)
    merged = color.copy()
    opaque_share = 1.0 - clear_share * (share[..., 0] / np.float32(255))
    merged[..., 3] = np.round(color[..., 3] * opaque_share).astype(np.uint8)
    return textures.add(merged)
