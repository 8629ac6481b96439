"""Materials of USD: UsdPreviewSurface, and the pictures that its inputs are connected to."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.files.usd_library import UsdObject, check_asset, float_array, usd_module
from heatlens.media.scene.material import Color, Material
from heatlens.media.scene.picture_read import read_picture
from heatlens.media.scene.usd.stage import UsdStage

_BLEND_CUTOFF = 0.5


@dataclass
class UsdMaterials:
    """The materials that prims are bound to, without repeats; the first is for unbound prims."""

    stage: UsdStage
    materials: list[Material] = field(default_factory=lambda: [Material()])
    images: list[NDArray[np.uint8]] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # used as an ordered set
    shaders: set[int] = field(default_factory=set)  # numbers of materials that have a shader
    _numbers_by_name: dict[str, int] = field(default_factory=dict)
    _pictures: dict[str, int | None] = field(default_factory=dict)

    def number_of(self, prim: UsdObject, has_own_colors: bool = False) -> int:
        """Return the number of the material that a mesh or a part of it is bound to.

        With `has_own_colors`, an unbound mesh is white, because its vertices have the colors.
        """
        shade = usd_module("UsdShade")
        bound_material, _ = shade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        surface = bound_material.ComputeSurfaceSource()[0] if bound_material else None
        stored = prim.GetAttribute("primvars:displayColor").Get()
        color = float_array(stored, 3, f"{self.stage.path}: displayColor of {prim.GetPath()}")[
            :1
        ].tolist()
        color = [(1.0, 1.0, 1.0)] if has_own_colors else color
        name = str(bound_material.GetPath()) if surface else f"color {color}" if color else ""
        if not name:
            return 0
        if name not in self._numbers_by_name:
            material = (
                self._read_surface(bound_material.GetPrim().GetName(), surface) if surface else None
            )
            self.materials.append(material or Material(base_color=_clip_color(color[0])))
            self._numbers_by_name[name] = len(self.materials) - 1
            self.shaders |= {self._numbers_by_name[name]} if surface else set()
        return self._numbers_by_name[name]

    def _read_surface(self, name: str, surface: UsdObject) -> Material:
        """Return the material of a UsdPreviewSurface that is called `name`."""
        base, base_map = self._read_input(surface, "diffuseColor", 0.18, 0.18, 0.18)
        glow, glow_map = self._read_input(surface, "emissiveColor", 0.0, 0.0, 0.0)
        opacity, _ = self._read_input(surface, "opacity", 1.0)
        threshold, _ = self._read_input(surface, "opacityThreshold", 0.0)
        opacity_input = surface.GetInput("opacity")
        is_cut = _clip_share(opacity) < 1 or bool(
            opacity_input and opacity_input.HasConnectedSource()
        )
        return Material(
            name=name,
            base_color=_clip_color(base) if base_map is None else (1.0, 1.0, 1.0),
            base_alpha=_clip_share(opacity),
            metallic=_clip_share(self._read_input(surface, "metallic", 0.0)[0]),
            roughness=_clip_share(self._read_input(surface, "roughness", 0.5)[0]),
            emission=_clip_color(glow) if glow_map is None else (1.0, 1.0, 1.0),
            alpha_cutoff=_clip_share(threshold) or (_BLEND_CUTOFF if is_cut else 0.0),
            base_color_map=base_map,
            emission_map=glow_map,
        )

    def _read_input(
        self, surface: UsdObject, name: str, *default: float
    ) -> tuple[tuple[float, ...], int | None]:
        """Return the value of an input, with as many numbers as `default`, and its picture's index.

        An input with a picture has the default value. The index is None without a usable picture.
        """
        entry = surface.GetInput(name)
        if not entry:
            return default, None
        sources = entry.GetConnectedSources()[0]
        if not sources:
            label = f"{self.stage.path}: {name} of {surface.GetPath()}"
            values = float_array(entry.Get(), len(default), label)
            return (tuple(values[0].tolist()) if len(values) else default), None
        file = sources[0].source.GetPrim().GetAttribute("inputs:file").Get()
        is_file = isinstance(file, usd_module("Sdf").AssetPath)
        if not is_file or name not in ("diffuseColor", "emissiveColor"):
            return default, None
        return default, self._picture_number(file.resolvedPath or file.path)

    def _picture_number(self, path: str) -> int | None:
        """Return the index of a picture in the images; None, with a note, if it cannot be read."""
        if path not in self._pictures:
            try:
                self.images.append(self._open_picture(path))
                self._pictures[path] = len(self.images) - 1
            except InputError as error:
                message = str(error).removeprefix(f"{self.stage.path}: ").rstrip(".")
                self.notes[f"{message}; it is ignored."] = None
                self._pictures[path] = None
        return self._pictures[path]

    def _open_picture(self, path: str) -> NDArray[np.uint8]:
        """Return the pixels of a picture; raise InputError if it is missing or no picture."""
        resolver = usd_module("Ar")
        check_asset(self.stage.path, path)
        asset = resolver.GetResolver().OpenAsset(resolver.ResolvedPath(path))
        if not asset:
            raise InputError(f"{self.stage.path}: the picture {path[:80]!r} is missing.")
        with asset:
            data = bytes(asset.GetBuffer())
        return read_picture(data, f"{self.stage.path}: {path}", self.images)


def _clip_color(value: Iterable[float]) -> Color:
    """Return a color; negative, infinite and NaN values become 0."""
    red, green, blue = (float(v) if 0 <= v < math.inf else 0.0 for v in value)
    return red, green, blue


def _clip_share(value: tuple[float, ...]) -> float:
    """Clip to 0..1; NaN becomes 0."""
    return min(value[0], 1.0) if value[0] > 0 else 0.0
