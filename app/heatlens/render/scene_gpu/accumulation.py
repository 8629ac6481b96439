"""Depth of field by accumulation: the mean of the views from many points of the lens.

Haeberli and Akeley 1990. It includes surfaces that a pinhole cannot see, which other methods guess,
but the scene is drawn once for each point.

The points of the lens and of a pixel are spread so evenly that few of them are enough: Sobol's
sequence in four dimensions, the first two for the lens, scrambled as Owen 1995 does by the hash of
Laine and Karras 2011 with the constants of Burley 2020. Later points of the sequence go on filling
the gaps between the earlier ones.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.lens.pupil import Pupil
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Image, Texture
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.scene_gpu.raster import SceneRaster

Colors = tuple[float, float, float, float]  # red, green, blue, alpha: 1 where a view counts
SIDES_LAYERS = 5  # layers of the image in lib/sides.lib.glsl
_ALL_COLORS: Colors = (1.0, 1.0, 1.0, 1.0)
_EACH_COLOR: tuple[Colors, ...] = ((1.0, 0, 0, 0), (0, 1.0, 0, 1.0), (0, 0, 1.0, 0))  # alpha: green
Array = NDArray[np.float64]
Words = NDArray[np.uint32]

_BITS = 32  # bits of a coordinate, which is a fraction of 2^32
# Joe and Kuo 2008, new-joe-kuo-6.21201: coefficients of the polynomial and first odd numbers, for
# each dimension after the first, which is van der Corput's.
_POLYNOMIALS = (((), (1,)), ((1,), (1, 3)), ((0, 1), (1, 3, 1)))
_FACTORS = (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6)  # constants of the hash, Burley 2020


class Accumulation:
    """Keeps the sum of the views so far, so that more views cost only the new ones."""

    def __init__(self, ctx: Device, raster: SceneRaster) -> None:
        self._raster = raster
        self._program = ComputeProgram(ctx, "scene_gpu/accumulate.comp.glsl")
        self._pool = TexturePool(ctx)
        # Identifies the scene, view, lens and size of the sum; None before the first view.
        self._key: tuple[object, tuple[int, int]] | None = None
        self._count = 0  # views in the sum

    def release(self) -> None:
        """Release everything on the GPU."""
        self._program.release()
        self._pool.release()

    def steps(
        self, view: SceneView, pupil: Pupil, views: int, out: Texture, key: object
    ) -> Iterator[str]:
        """Render the mean of `views` views through `pupil` into `out`.

        `out` is RGBA of the view's size, half or float32. It holds the mean so far after each step
        called "view"; steps called "band" come between. The caller passes equal keys only for an
        equal scene, view and lens; the sum for an equal key is continued. For fewer views than were
        summed, the sum starts again: the picture depends on the number of views alone. A pupil of
        radius 0 gives the antialiased picture of a pinhole.

        If the pupil is not plain, each pixel weighs the views by the light that reaches its
        position in the picture. If each color has its own focus, a view is drawn for each color.
        """
        if self._key != (key, view.size) or self._count > views:
            self._key, self._count = (key, view.size), 0
        if self._count == views:  # there is nothing to draw, only the mean to write
            weights = _weight_uniforms(pupil, view, (0.0, 0.0), _ALL_COLORS)
            self._add(out, pupil, weights, is_new=False)
            return
        offsets, jitters = lens_samples(self._count, views, pupil)
        for (u, v), (x, y) in zip(offsets.tolist(), jitters.tolist(), strict=True):
            index = self._count
            sample_view = replace(view, offset_m=(u, v), jitter_px=(x, y), sample=index)
            for colors, color_view in _views_of_colors(pupil, sample_view):
                yield from self._draw(color_view, not pupil.is_plain)
                weights = _weight_uniforms(pupil, color_view, (u, v), colors)
                # Blue is drawn last and red first; a view of all colors is both.
                is_last = colors[2] == 1.0
                is_first = index == 0 and colors[0] == 1.0
                self._add(out, pupil, weights, is_new=True, is_first=is_first)
                self._count += is_last
                yield "view" if is_last else "band"

    def _draw(self, view: SceneView, has_depth: bool) -> Iterator[str]:
        """Draw a view into the texture "view", and its depth into "depth" if requested, in bands.

        A step "band" comes between two bands.
        """
        view_texture = self._pool.texture("view", view.size, 4)
        for band in self._raster.bands.of(view.size):
            self._raster.draw(view, view_texture, band)
            if has_depth:
                self._raster.depth(view, self._pool.texture("depth", view.size, 1), band)
            if band.y1 < view.size[1]:
                yield "band"

    def _add(
        self,
        out: Texture,
        pupil: Pupil,
        weights: dict[str, object] | None,
        is_new: bool,
        is_first: bool = False,
    ) -> None:
        """Add the view that was drawn last to the sum, and write the mean to `out`.

        `weights` are the uniforms that weigh the view; None if all views weigh the same. If not
        `is_new`, only the mean is written again. `is_first` begins the sum.
        """
        textures = {"view_tx": self._pool.texture("view", out.size, 4)}
        images: dict[str, Image] = {"mean_img": out}
        if weights is not None:
            textures["depth_tx"] = self._pool.texture("depth", out.size, 1)
            images["sides_img"] = self._pool.array("sides", out.size, SIDES_LAYERS, 4)
        else:
            images["sum_img"] = self._pool.texture("sum", out.size, 4)
        self._program.version(**pupil.switches).dispatch(
            pixel_groups(out.size),
            textures=textures,
            images=images,
            uniforms={
                "count": float(self._count + is_new),
                "is_first": is_first,
                "is_new": is_new,
                **(weights or {}),
            },
        )


def _views_of_colors(pupil: Pupil, view: SceneView) -> Iterator[tuple[Colors, SceneView]]:
    """Yield one view for all colors, or one each if every color has its own focus.

    The first value of a pair is 1 for each color that the view counts for.
    """
    if pupil.axial_dioptres == 0.0:
        yield _ALL_COLORS, view
        return
    for index, colors in enumerate(_EACH_COLOR):
        dioptres = 1 / view.focus_m + (index - 1) * pupil.axial_dioptres
        yield colors, replace(view, focus_m=1 / dioptres if dioptres else math.inf)


def _weight_uniforms(
    pupil: Pupil, view: SceneView, offset_m: tuple[float, float], colors: Colors
) -> dict[str, object] | None:
    """Return the uniforms that weigh a view; None if all views weigh the same."""
    if pupil.is_plain:
        return None
    across, up = pupil.half_extents_m
    return pupil.uniforms(view.size) | {
        "lens_point": (offset_m[0] / across, offset_m[1] / up),
        "focus_dioptres": 1 / view.focus_m,
        **view.focus_offset.uniforms(1.0),
        "focal_px": view.focal_px,
        "colors": colors,
    }


def lens_samples(
    count_from: int, count_to: int, pupil: Pupil, seed: int = 0
) -> tuple[Array, Array]:
    """Return the offsets and jitters, (n, 2) each, of samples `count_from` to `count_to` - 1.

    Offsets are uniform over `pupil`, in meters, jitters over the pixel, [-0.5, 0.5). Equal numbers
    and an equal seed, 0 to 2^32 - 1, give equal points.
    """
    points = _sobol(np.arange(count_from, count_to, dtype=np.uint32), seed)
    return pupil.points_m(points[:, :2]), points[:, 2:] - 0.5


def _sobol(numbers: Words, seed: int) -> Array:
    """Return the scrambled points (n, 4), in [0, 1), of Sobol's sequence at these `numbers`."""
    words = np.stack([_digits(numbers, column) for column in _DIRECTIONS], axis=-1)
    salts = _hash_words(np.arange(1, 5, dtype=np.uint32) ^ _hash_words(np.array([seed], np.uint32)))
    return np.asarray(_scramble(words, salts) / 2.0**_BITS)


def _directions() -> Words:
    """Return (4, 32) words: the bits that each bit of a number flips in each dimension."""
    first = [1 << (_BITS - 1 - bit) for bit in range(_BITS)]
    rows = [first, *(_direction_row(*polynomial) for polynomial in _POLYNOMIALS)]
    return np.array(rows, np.uint32)


def _direction_row(inner: tuple[int, ...], start: tuple[int, ...]) -> list[int]:
    """Return the 32 direction words of the dimension with one primitive polynomial.

    `inner` are the inner coefficients of the polynomial and `start` the first odd numbers. The
    recurrence is that of Bratley and Fox 1988.
    """
    degree = len(start)
    row = [number << (_BITS - 1 - bit) for bit, number in enumerate(start)]
    for bit in range(degree, _BITS):
        word = row[bit - degree] ^ (row[bit - degree] >> degree)
        for back, coefficient in enumerate(inner, start=1):
            word ^= coefficient * row[bit - back]
        row.append(word)
    return row


_DIRECTIONS = _directions()


def _digits(numbers: Words, directions: Words) -> Words:
    """Return the coordinates of points along one dimension, as fractions of 2^32.

    `numbers` are those of the points, and `directions` the words of `_directions` for a dimension.
    """
    words = np.zeros_like(numbers)
    for bit, direction in enumerate(directions):
        words ^= (numbers >> np.uint32(bit) & np.uint32(1)) * direction
    return words


def _scramble(words: Words, salts: Words) -> Words:
    """Flip each bit by a hash of the bits above it, which keeps the points evenly spread.

    Each dimension has a salt, which makes its hash another one.
    """
    hashed = _reverse_bits(words) + salts
    for factor in _FACTORS:
        hashed ^= hashed * np.uint32(factor)
    return _reverse_bits(hashed)


def _reverse_bits(words: Words) -> Words:
    """Return the words with their bits in reverse order."""
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF)):
        step, low = np.uint32(shift), np.uint32(mask)
        words = ((words >> step) & low) | ((words & low) << step)
    return (words >> np.uint32(16)) | (words << np.uint32(16))


def _hash_words(words: Words) -> Words:
    """Hash numbers with the finalizer of MurmurHash3, which makes neighboring numbers unlike."""
    words = (words ^ (words >> np.uint32(16))) * np.uint32(0x85EBCA6B)
    words = (words ^ (words >> np.uint32(13))) * np.uint32(0xC2B2AE35)
    return words ^ (words >> np.uint32(16))
