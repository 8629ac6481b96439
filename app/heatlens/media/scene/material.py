"""The material of a surface, and the pictures on it."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

Color = tuple[float, float, float]


class Wrap(IntEnum):
    """How a picture continues beyond its borders; the shaders use the same numbers."""

    REPEAT = 0
    CLAMP = 1
    MIRROR = 2


@dataclass(frozen=True)
class MapPlace:
    """The placement of a map on a surface.

    Texture coordinates (u, v) become matrix @ (u, v) + offset, where matrix is two rows.
    `coordinates` is the number of their set: 0 for a mesh's `uvs`, 1 for its `more_uvs`. `wraps`
    says how the picture continues beyond its borders along u and v.
    """

    coordinates: int = 0
    matrix: tuple[tuple[float, float], tuple[float, float]] = ((1.0, 0.0), (0.0, 1.0))
    offset: tuple[float, float] = (0.0, 0.0)
    wraps: tuple[Wrap, Wrap] = (Wrap.REPEAT, Wrap.REPEAT)

    @property
    def is_wrapped(self) -> bool:
        """Whether the picture is not simply repeated beyond its borders."""
        return self.wraps != (Wrap.REPEAT, Wrap.REPEAT)

    def transform(self, uvs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return texture coordinates (V, 2) after the transform, without the wrapping."""
        transformed = uvs @ np.array(self.matrix).T + np.array(self.offset)
        return np.asarray(transformed, np.float32)


@dataclass(frozen=True)
class Material:
    """A surface in the metallic and roughness model of glTF 2.0, visible from both sides.

    base_color     scene-linear RGB, multiplied by the map
    emission       scene-linear radiance, far above 1 for a lamp, multiplied by the map
    alpha_cutoff   the surface has holes where the base color's alpha is lower; 0 for no holes
    is_blended     alpha is the share of the surface that covers what is behind it
    is_lit         False for a surface that shows its base color in any light
    *_map          index into the scene's images, None for none; metallic is in the blue channel,
                   roughness in the green one; a normal map is as in glTF, y against v
    normal_scale   steepness of the bumps in the normal map; 0 for none
    occlusion      how much of the sky's light the red channel of its map can remove, 0 to 1
    map_places     placement of the five maps in the order of `maps`; None for plain uvs
    """

    name: str = ""
    base_color: Color = (0.8, 0.8, 0.8)
    base_alpha: float = 1.0
    metallic: float = 0.0
    roughness: float = 0.6
    emission: Color = (0.0, 0.0, 0.0)
    alpha_cutoff: float = 0.0
    base_color_map: int | None = None
    metallic_roughness_map: int | None = None
    emission_map: int | None = None
    normal_map: int | None = None
    normal_scale: float = 1.0
    occlusion_map: int | None = None
    occlusion: float = 1.0
    is_blended: bool = False
    is_lit: bool = True
    map_places: tuple[MapPlace, ...] | None = None

    @property
    def maps(self) -> tuple[int | None, ...]:
        """The maps of base color, metal and roughness, emission, normals, and occlusion."""
        metal_and_roughness = self.metallic_roughness_map
        return (
            *(self.base_color_map, metal_and_roughness, self.emission_map),
            *(self.normal_map, self.occlusion_map),
        )
