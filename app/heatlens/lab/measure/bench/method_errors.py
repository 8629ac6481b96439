"""Measure the error of each method to the truth, and its time, against the amount of blur.

They are measured in a scene whose blur is difficult to compute. Glowing boards stand one behind the
other, from a post by the camera to the sky, over a ground that extends through all depths. Lamps
are placed where bright discs cross silhouettes; one is behind the post, where only a lens sees it.
"""

import math
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import VIEWS_MAX, DefocusSettings, Method
from heatlens.lab.measure.bench import methods, timing
from heatlens.lab.measure.bench.methods import compared_methods, most_views, wall_framing
from heatlens.lab.measure.bench.synthetic_plate import LENS
from heatlens.lab.measure.bench.timing import (
    BenchFrames,
    Frame,
    MethodTimer,
    ReportProgress,
    SceneFrame,
)
from heatlens.lab.measure.metrics import score
from heatlens.media.plate.plate import FloatImage
from heatlens.media.scene.material import Color, Material
from heatlens.media.scene.scene import Daylight, Instance, Mesh, Scene
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.frame_renderer import run_all_steps
from heatlens.render.gpu.textures import download

_REPORT_EVERY = 256  # views of the truth
_SIDE_MIN_PX = 16
NEAREST_M = 1.0  # distance of the nearest board, which has the largest circle of confusion

_ASPECT = 9 / 16  # the boards are placed in a frame of this shape, and shares of it
_BLACK = (0.0, 0.0, 0.0)
_NIGHT = Daylight(sun=_BLACK, zenith=_BLACK, horizon=_BLACK, ground=_BLACK)

# Left, right (of the width), top, bottom (of the height), meters away, color.
_BOARDS = (
    (-1.0, 2.0, -2.0, 3.0, 40.0, (0.35, 0.50, 0.80)),  # the sky
    (0.08, 0.34, 0.22, 0.60, 20.0, (0.60, 0.45, 0.35)),  # a house
    (0.60, 0.70, 0.12, 0.66, 8.0, (0.10, 0.26, 0.08)),  # a tree
    (0.38, 0.50, 0.25, 0.85, 3.0, (0.75, 0.25, 0.12)),  # what the lens is focused on
    (0.20, 0.21, -0.50, 1.50, 1.6, (0.03, 0.03, 0.04)),  # wires
    (0.27, 0.275, -0.50, 1.50, 1.6, (0.03, 0.03, 0.04)),
    (0.54, 0.546, -0.50, 1.50, 2.2, (0.05, 0.04, 0.03)),
    (0.80, 0.92, 0.12, 1.60, NEAREST_M, (0.12, 0.30, 0.50)),  # a post by the camera
)
_LAMPS = ((0.13, 0.30), (0.265, 0.34), (0.515, 0.20), (0.59, 0.30), (0.72, 0.22), (0.86, 0.30))
_LAMP_M = 12.0
_LAMP_SIDE = 0.01  # share of the width
_LAMP_LIGHT = (50.0, 32.0, 12.0)  # scene-linear, hundreds of times the ground
_GROUND_LIGHT = (0.30, 0.26, 0.18)
_GROUND_M = (1.2, 40.0)  # nearest and farthest point of the ground, _EYE_M below the camera
_EYE_M = 0.5


@dataclass(frozen=True, slots=True)
class ErrorCell:
    """One method at one amount of blur: milliseconds of a frame, and its error to the truth.

    The scores are those of `lab.measure.metrics.Scores`: FLIP 0 and SSIM 1 if equal, PSNR in dB.
    """

    ms: float
    flip: float
    psnr_db: float
    ssim: float


@dataclass(frozen=True, slots=True)
class ErrorRow:
    """The cells by each method's name; None if a frame took longer than the limit.

    coc_px      the largest circle of confusion in the picture
    truth_flip  FLIP between the truth and that of half its views, a measure of its noise
    """

    coc_px: float
    truth_flip: float
    cells: dict[str, ErrorCell | None]


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """All methods on one scene through lenses of growing blur.

    truth_views  number of points of the lens over which the truth is averaged
    """

    width: int
    height: int
    limit_s: float
    truth_views: int
    rows: tuple[ErrorRow, ...]


def check_errors(size: tuple[int, int], settings: DefocusSettings, truth_views: int) -> None:
    """Raise InputError for options that would fail only after minutes, or give no valid truth."""
    views_max = most_views(settings)
    if not views_max < truth_views <= VIEWS_MAX:
        raise InputError(
            f"--truth-views must be above {views_max}, the views of the methods, and at most "
            f"{VIEWS_MAX}, or 0 to measure only times; got {truth_views}."
        )
    if min(proxy_size(size, settings.proxy)) < _SIDE_MIN_PX:
        raise InputError(
            f"--truth-size {size[0]}x{size[1]} is too small for comparing pictures: at least "
            f"{_SIDE_MIN_PX} pixels a side are needed, after --proxy."
        )
    black = np.zeros((_SIDE_MIN_PX, _SIDE_MIN_PX, 3), np.float32)
    try:
        score(black, black)  # raises if a package for the metrics is missing
    except InputError as error:
        raise InputError(f"{error}; or leave errors out: --truth-views 0") from error


def measure_errors(
    frames: BenchFrames,
    size: tuple[int, int],
    settings: DefocusSettings,
    truth_views: int,
    runs: int,
    report_progress: ReportProgress,
) -> ErrorReport:
    """Measure time and error of each method on the truth scene.

    Plate methods get the pinhole picture of the scene. A method that was too slow once is left out
    of the following rows.
    """
    frame = frames.scene_frame(truth_scene(), wall_framing(size), LENS, settings)
    frame.renderer.load_pinhole(
        frame.shot
    )  # now, so that it is not included in the time of the first method
    timer = MethodTimer(runs, report_progress)
    rows = []
    for coc in methods.METHOD_COC_PX:
        lens_frame = replace(frame, shot=replace(frame.shot, lens=truth_lens(coc, size[0])))
        rows.append(_measure_row(lens_frame, coc, truth_views, timer, report_progress))
    return ErrorReport(*size, timing.LIMIT_S, truth_views, tuple(rows))


def _measure_row(
    frame: SceneFrame,
    coc_px: float,
    truth_views: int,
    timer: MethodTimer,
    report_progress: ReportProgress,
) -> ErrorRow:
    """Render the truth for one amount of blur and compare every method with it."""
    blur_text = largest_coc_text(coc_px)
    truth, truth_flip = render_truth(
        frame, truth_views, lambda done: report_progress(f"{done}, {blur_text}")
    )
    cells = {
        name: _measure_cell(timer, name, _with_settings(frame, method_settings), truth, blur_text)
        for name, method_settings in compared_methods(frame.shot.defocus).items()
    }
    return ErrorRow(coc_px, truth_flip, cells)


def largest_coc_text(coc_px: float) -> str:
    """Return the text after a truth or a method's name in progress messages."""
    return f"largest circle of confusion {coc_px:g} px"


def truth_message(views: int) -> str:
    """Return the progress message of a truth."""
    return f"truth from {views} views"


def render_truth(
    frame: SceneFrame, views: int, report_progress: ReportProgress
) -> tuple[FloatImage, float]:
    """Return the mean of `views` views, (H, W, 3) scene-linear, and the FLIP of half of them."""
    pictures = []
    for view_count in (max(views // 2, 1), views):  # the second continues the first
        settings = replace(frame.shot.defocus, method=Method.ACCUMULATION, views=view_count)
        pictures.append(_render_truth(_with_settings(frame, settings), view_count, report_progress))
    half_views_picture, picture = pictures
    return picture, score(half_views_picture, picture).flip


def _render_truth(frame: SceneFrame, views: int, report_progress: ReportProgress) -> FloatImage:
    """Return the mean (H, W, 3) of all views of the shot's settings through its lens.

    `views` is their number, for the message. Progress is reported every `_REPORT_EVERY` views.
    """
    report_progress(truth_message(views))
    views_done = count(1)

    def count_view(step: str) -> None:
        if step == "view" and (done := next(views_done)) % _REPORT_EVERY == 0:
            report_progress(f"truth, {done} views more")

    return _rgb(download(run_all_steps(frame.renderer.steps(frame.shot), count_view)))


def _measure_cell(
    timer: MethodTimer, name: str, frame: Frame, truth: FloatImage, blur_text: str
) -> ErrorCell | None:
    """Time and compare one method; return None if it is too slow."""
    timed = timer.time_method(name, lambda: frame, blur_text)
    if timed is None:
        return None
    scores = score(_rgb(download(timed.picture)), truth)
    return ErrorCell(timed.ms, scores.flip, scores.psnr_db, scores.ssim)


def _with_settings(frame: SceneFrame, settings: DefocusSettings) -> SceneFrame:
    """Return the frame with other settings."""
    return replace(frame, shot=replace(frame.shot, defocus=settings))


def _rgb(rgba: FloatImage) -> FloatImage:
    return np.ascontiguousarray(rgba[..., :3])


def truth_scene() -> Scene:
    """Return the boards, the ground and the lamps, before a camera in the origin along -z."""
    boards = [(_board(*board[:5]), board[5], 0) for board in _BOARDS]
    lamps = [(_board(*_lamp_edges(x, y), _LAMP_M), _LAMP_LIGHT, None) for x, y in _LAMPS]
    things = [*boards, (_ground(), _GROUND_LIGHT, 0), *lamps]
    return Scene(
        Path("synthetic"),
        tuple(replace(mesh, material=index) for index, (mesh, _, _) in enumerate(things)),
        tuple(Instance(f"{index}", index, np.eye(4)) for index in range(len(things))),
        tuple(_glowing_material(light, picture) for _, light, picture in things),
        (_wave_picture(),),
        daylight=_NIGHT,
    )


def truth_lens(largest_coc_px: float, width_px: int) -> Lens:
    """Return `LENS` with the f-stop at which the nearest board's |coc| is `largest_coc_px`.

    The coc is proportional to 1 / f-stop.
    """
    nearest = abs(float(coc_px(NEAREST_M, coc_line(LENS, width_px))))
    return replace(LENS, f_stop=LENS.f_stop * nearest / largest_coc_px)


def _glowing_material(light: Color, picture: int | None) -> Material:
    """Return a material that only emits light, times a picture if it has one."""
    return Material("light", _BLACK, emission=light, emission_map=picture)


def _lamp_edges(x: float, y: float) -> tuple[float, float, float, float]:
    """Return left, right, top and bottom of a lamp whose centre is (x, y)."""
    half_x, half_y = _LAMP_SIDE / 2, _LAMP_SIDE / 2 / _ASPECT
    return x - half_x, x + half_x, y - half_y, y + half_y


def _board(left: float, right: float, top: float, bottom: float, away_m: float) -> Mesh:
    """Return a board upright across the view.

    Its texture is equally fine on screen at any distance.
    """
    u, v = np.array((left, right, right, left)), np.array((bottom, bottom, top, top))
    frame_m = away_m * LENS.sensor_width_mm / LENS.focal_length_mm
    x, y = frame_m * (u - 0.5), -frame_m * _ASPECT * (v - 0.5)
    positions = np.stack([x, y, np.full(4, -away_m)], axis=1)
    return _quad(positions, (0.0, 0.0, 1.0), 2.0 * np.stack([u, v * _ASPECT], axis=1))


def _ground() -> Mesh:
    """Return the ground from the nearest to the farthest point."""
    near, far = _GROUND_M
    x, z = np.array((-far, far, far, -far)), np.array((-near, -near, -far, -far))
    positions = np.stack([x, np.full(4, -_EYE_M), z], axis=1)
    return _quad(positions, (0.0, 1.0, 0.0), 0.25 * np.stack([x, z], axis=1))


def _quad(corners: ArrayLike, normal: ArrayLike, uvs: ArrayLike) -> Mesh:
    """Return a mesh of two triangles with these four corners."""
    return Mesh(
        positions_m=np.asarray(corners, np.float32),
        normals=np.tile(np.asarray(normal, np.float32), (4, 1)),
        uvs=np.asarray(uvs, np.float32),
        triangles=np.array(((0, 1, 2), (0, 2, 3)), np.uint32),
    )


def _wave_picture(side: int = 128) -> NDArray[np.uint8]:
    """Return (side, side, 4) waves at several scales that repeat without a seam."""
    v, u = math.tau * np.mgrid[:side, :side] / side
    waves = sum(np.sin(n * u + n) * np.sin((n + 1) * v) for n in (1, 3, 8))
    grey = np.rint(255 * (0.7 + 0.1 * np.asarray(waves)))
    return np.stack([grey, grey, grey, np.full_like(grey, 255)], axis=-1).astype(np.uint8)
