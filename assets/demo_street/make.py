"""Make the street of the demo, assets/demo.glb: run `python -m demo_street.make` in assets.

Puddles are holes in the wet ground, and a mirrored street hangs below it. A mirror image is
therefore as far away as its light has travelled, and a lens blurs it accordingly.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from demo_street.actors import Clothes, Walk, dress
from demo_street.cafe import build_cafe
from demo_street.gltf_file import glb_of
from demo_street.shapes import quads, scaled
from demo_street.street import build_street
from demo_street.street_set import DemoSet
from heatlens.media.scene.scene import Material

_SKIN = (0.55, 0.34, 0.24)
ACTORS = {
    "actor A": Walk((0.5, -3.47), (0.62, 0.2), 30, -1, 4),
    "actor B": Walk((-0.75, -5.85), (1.25, 0.25), 117, 1, 6),
    "actor C": Walk((1.2, -10.3), (2.2, 0.42), 220, 1, 8),
}
_CLOTHES = (
    Clothes((0.42, 0.045, 0.035), (0.05, 0.06, 0.1), (0.7, 0.6, 0.42), (0.62, 0.5, 0.3), _SKIN),
    Clothes(
        (0.03, 0.2, 0.22), (0.07, 0.06, 0.05), (0.6, 0.2, 0.08), (0.05, 0.04, 0.04), _SKIN, True
    ),
    Clothes((0.55, 0.36, 0.07), (0.04, 0.05, 0.09), (0.08, 0.16, 0.32), (0.3, 0.04, 0.06), _SKIN),
)
_TILE_M = 9.0  # period of the puddles
_TILE_PX = 256
_REFLECTED = 0.3  # share of the light that water reflects at so flat an angle
_MIRRORED = ("houses", "windows", "street lamps", "garlands", "signs", "shops", "cars")


def street_bytes() -> bytes:
    """Return the street with its people as a .glb."""
    stage = DemoSet()
    build_street(stage)
    puddles = add_puddles(stage)
    build_cafe(stage)
    still = len(stage.instances)
    joints = [
        (ACTORS[name], joint)
        for name, clothes in zip(ACTORS, _CLOTHES, strict=True)
        for joint in dress(stage, name, clothes)
    ]
    return glb_of(stage, puddles, dict(enumerate(joints, still)))


def add_puddles(stage: DemoSet) -> npt.NDArray[np.uint8]:
    """Add the ground and the mirror images in its puddles; return the map of the ground.

    The map is the first image of the scene, (H, W, 4), with holes where alpha is under one half.
    """
    for name in _MIRRORED:
        _mirror(stage, name)
    wet = Material(
        "asphalt", (0.032, 0.034, 0.04), roughness=0.26, alpha_cutoff=0.5, base_color_map=0
    )
    corners = np.array([(-30, 0, 6), (30, 0, 6), (30, 0, -75), (-30, 0, -75)], np.float64)
    ground = replace(quads([corners]), uvs=(corners[:, [0, 2]] / _TILE_M).astype(np.float32))
    stage.put("ground", stage.mesh(ground, stage.material(wet)), np.eye(4))
    return _puddle_map(np.random.default_rng(11))


def _mirror(stage: DemoSet, name: str) -> None:
    """Add each instance of that name once more, upside down and darker."""
    darker: dict[int, int] = {}
    for instance in [one for one in stage.instances if one.name == name]:
        if instance.mesh not in darker:
            mesh = stage.meshes[instance.mesh]
            material = stage.material(_reflected(stage.materials[mesh.material]))
            darker[instance.mesh] = stage.mesh(mesh, material)
        flipped = scaled(1, -1, 1) @ instance.to_world
        stage.put("reflections", darker[instance.mesh], flipped)


def _reflected(material: Material) -> Material:
    base, emission = (
        tuple(_REFLECTED * value for value in color)
        for color in (material.base_color, material.emission)
    )
    return replace(
        material,
        base_color=(base[0], base[1], base[2]),
        emission=(emission[0], emission[1], emission[2]),
    )


def _puddle_map(rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Return a map of waves that repeat on a tile; the lowest parts are under water."""
    at = 2 * np.pi * np.arange(_TILE_PX) / _TILE_PX
    height = np.zeros((_TILE_PX, _TILE_PX))
    for _ in range(24):
        across, along = rng.integers(-4, 5, 2)
        share = rng.normal() / (1.0 + across**2 + along**2) ** 0.5
        height += share * np.cos(across * at + along * at[:, None] + rng.uniform(0, 2 * np.pi))
    height = (height - np.quantile(height, 0.34)) / height.std()
    pixels = np.full((_TILE_PX, _TILE_PX, 4), 255, np.uint8)
    pixels[..., 3] = np.clip(127.5 + 127.5 * height / 0.4, 0, 255).astype(np.uint8)
    return pixels


if __name__ == "__main__":
    (Path(__file__).parents[1] / "demo.glb").write_bytes(street_bytes())
