"""Draw glass as a thin pane: a part of it is opaque, and the rest transmits light.

Source: Khronos, KHR_materials_transmission.
"""

from dataclasses import replace

import numpy as np

from heatlens.scene.gltf.glossiness import common_size, resized
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.gltf.textures import GltfTextures
from heatlens.scene.scene import Material

# Share of light that passes straight through clear glass; its two sides reflect the rest.
_CLEAREST = 0.9
_HOLED = "Glass with holes is opaque around them"
_BY_MEAN = "Transmission maps placed unlike the colour map are replaced by their mean"


def see_through(
    textures: GltfTextures, record: Record, material: Material, of_base: Record
) -> tuple[Material, Record]:
    """Return the material with its transmission, and the record that places its base colour map.

    A transmission map is merged into the alpha of the base colour map.
    """
    told = record.inside("extensions", "KHR_materials_transmission")
    through = min(told.number("transmissionFactor", 0.0, least=0.0), 1.0)
    if through and material.alpha_cutoff:
        textures.gltf.lose(_HOLED, record)
    if not through or material.alpha_cutoff:
        return material, of_base
    clear = min(_CLEAREST * through * sum(material.base_color) / 3, _CLEAREST)
    glass = replace(material, is_blended=True)
    info, number = told.inside("transmissionTexture"), textures.map(told, "transmissionTexture")
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
