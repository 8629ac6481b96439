"""Measure the time of every method against the amount of blur, and name the methods compared.

Methods that need a scene get a wall, with the same blur everywhere.
"""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.lab.measure.bench import timing
from heatlens.lab.measure.bench.synthetic_plate import LENS, uniform_coc_plate
from heatlens.lab.measure.bench.timing import BenchFrames, Frame, MethodTimer, ReportProgress
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import Daylight, Instance, Mesh, Scene

METHOD_COC_PX = (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
_SQUARES = (96, 54)  # twice as many triangles: about those of the built-in scene
_BLACK = (0.0, 0.0, 0.0)
_NIGHT = Daylight(sun=_BLACK, zenith=_BLACK, horizon=_BLACK, ground=_BLACK)
# Numbers of views in the literature, from Haeberli and Akeley 1990 on.
KNOWN_VIEWS = (23, 66)


@dataclass(frozen=True, slots=True)
class MethodRow:
    """Milliseconds of a frame by each method's name, with the same coc everywhere.

    They are the median of as many frames as the time limit allowed; None if not even one fitted.
    """

    coc_px: float
    ms: dict[str, float | None]


@dataclass(frozen=True, slots=True)
class MethodReport:
    """All methods over all circles of confusion; `limit_s` is the time limit of each cell."""

    width: int
    height: int
    limit_s: float
    rows: tuple[MethodRow, ...]


def measure_methods(
    frames: BenchFrames,
    size: tuple[int, int],
    settings: DefocusSettings,
    runs: int,
    report_progress: ReportProgress,
) -> MethodReport:
    """Measure each method on a plate of uniform coc, or on such a scene if it needs one.

    A method that was too slow once is left out of the following rows.
    """
    timer, rows = MethodTimer(runs, report_progress), []
    for coc in METHOD_COC_PX:
        ms: dict[str, float | None] = {}
        for name, method_settings in compared_methods(settings).items():
            make = partial(_uniform_frame, frames, size, coc, method_settings)
            timed = timer.time_method(name, make, coc_text(coc))
            ms[name] = None if timed is None else timed.ms
        rows.append(MethodRow(coc, ms))
    return MethodReport(*size, timing.LIMIT_S, tuple(rows))


def coc_text(coc_px: float) -> str:
    """Return the text after a method's name in progress messages."""
    return f"circle of confusion {coc_px:g} px"


def _uniform_frame(
    frames: BenchFrames, size: tuple[int, int], coc_px: float, settings: DefocusSettings
) -> Frame:
    """Return a frame that has the same coc everywhere."""
    if settings.method.needs_scene:
        scene = uniform_coc_scene(size, coc_px)
        return frames.scene_frame(scene, wall_framing(size), LENS, settings)
    return frames.frame(uniform_coc_plate(size, coc_px), LENS, settings)


def uniform_coc_scene(size: tuple[int, int], diameter_px: float) -> Scene:
    """Return a wall across the view that emits the colors of `uniform_coc_plate`, up to white.

    The wall is in front of the focus, where |coc| is `diameter_px`; behind the focus |coc| cannot
    exceed its value at infinity. The picture repeats beyond its border: the wall is all that any
    point of the lens sees.
    """
    distance_m = wall_m(size[0], diameter_px, LENS)
    wall = _wall(size, diameter_px, distance_m, LENS)
    glow = Material("wall", _BLACK, emission=(1.0, 1.0, 1.0), emission_map=0)
    instance = Instance(name="wall", mesh=0, to_world=np.eye(4))
    picture = _wall_picture(size, diameter_px)
    return Scene(Path("synthetic"), (wall,), (instance,), (glow,), (picture,), daylight=_NIGHT)


def wall_framing(size: tuple[int, int]) -> Framing:
    """Return the framing of a camera in the origin that looks along -z."""
    pose = pose_looking_at((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    return Framing(*size, track=CameraTrack((PoseKey(1, pose),)))


def wall_m(width_px: int, diameter_px: float, lens: Lens) -> float:
    """Return the distance in meters at which the coc is -`diameter_px`."""
    line = coc_line(lens, width_px)
    return line.per_dioptre_px / (-diameter_px - line.at_infinity_px)


def _wall(size: tuple[int, int], margin_px: float, distance_m: float, lens: Lens) -> Mesh:
    """Return a wall of _SQUARES over the picture, plus `margin_px` around them; uv is 0 to 1."""
    # The margin is one ring of squares of any width: the same number of triangles is in view for
    # every blur, and the rows of the table differ by the blur alone.
    x, y = (
        np.array([-margin_px, *np.linspace(0, side, count + 1), side + margin_px])
        for side, count in zip(size, _SQUARES, strict=True)
    )
    pixels = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    pixel_m = distance_m * lens.sensor_width_mm / (size[0] * lens.focal_length_mm)
    across, down = (pixel_m * (pixels - np.array(size) / 2)).T
    positions = np.stack([across, -down, np.full_like(down, -distance_m)], axis=1)
    return Mesh(
        positions_m=positions.astype(np.float32),
        normals=np.tile(np.array((0.0, 0.0, 1.0), np.float32), (len(positions), 1)),
        uvs=(pixels / size).astype(np.float32),
        triangles=_triangles(len(x), len(y)),
    )


def _triangles(columns: int, rows: int) -> NDArray[np.uint32]:
    """Return two triangles for each square of a grid of corners, front side towards +z."""
    corner = np.arange(columns * rows, dtype=np.uint32).reshape(rows, columns)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def _wall_picture(size: tuple[int, int], diameter_px: float) -> NDArray[np.uint8]:
    """Return the display values of the wall, (H, W, 4)."""
    light = uniform_coc_plate(size, diameter_px).color
    display = np.ones_like(light)
    display[..., :3] = np.clip(encode_srgb(light[..., :3]), 0.0, 1.0)
    return np.asarray(np.rint(255 * display), np.uint8)


def compared_methods(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Return the settings of every method by its name, in the order of `Method`.

    The name of a method that averages views contains their number: "accumulation 23".
    """
    settings_of: dict[str, DefocusSettings] = {}
    for method in Method:
        method_settings = replace(settings, method=method)
        if method.needs_scene:
            settings_of |= {
                f"{method} {views}": replace(method_settings, views=views)
                for views in _views(method_settings)
            }
        else:
            settings_of[str(method)] = method_settings
    return settings_of


def most_views(settings: DefocusSettings) -> int:
    """Return the largest number of views that any method of a bench renders."""
    return max(KNOWN_VIEWS[-1], settings.views)


def _views(settings: DefocusSettings) -> list[int]:
    """Return the numbers of views to measure; for accumulation, those of the literature too."""
    known_views = KNOWN_VIEWS if settings.method is Method.ACCUMULATION else ()
    return sorted({*known_views, settings.views})
