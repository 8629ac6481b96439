"""Measure the error of each method to the truth, and its time, against the amount of blur."""

from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from heatlens.base.errors import InputError
from heatlens.defocus.plate_passes import proxy_size
from heatlens.gpu.textures import download
from heatlens.measure.bench import bounded, methods
from heatlens.measure.bench.bounded import Patience, Say
from heatlens.measure.bench.entrants import entrants, most_views
from heatlens.measure.bench.frames import BenchFrames, Frame, SceneFrame
from heatlens.measure.bench.synthetic_plate import LENS
from heatlens.measure.bench.synthetic_scene import wall_framing
from heatlens.measure.bench.truth_scene import truth_lens, truth_scene
from heatlens.measure.compare.metrics import score
from heatlens.model.settings import VIEWS_MAX, DefocusSettings, Method
from heatlens.plate.plate import FloatImage
from heatlens.render import drained

_SAY_EVERY = 256  # views of the truth
_SIDE_MIN_PX = 16


@dataclass(frozen=True, slots=True)
class ErrorCell:
    """One method at one amount of blur: milliseconds of a frame, and its error to the truth.

    The scores are those of `measure.compare.metrics.Scores`: FLIP 0 and SSIM 1 if equal, PSNR in
    dB.
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
    most = most_views(settings)
    if not most < truth_views <= VIEWS_MAX:
        raise InputError(
            f"--truth-views must be more than the {most} views that are held against it and at "
            f"most {VIEWS_MAX}, or 0 for only times; got {truth_views}."
        )
    if min(proxy_size(size, settings.proxy)) < _SIDE_MIN_PX:
        raise InputError(
            f"--truth-size {size[0]}x{size[1]} is too small to compare pictures on; "
            f"{_SIDE_MIN_PX} pixels a side, after --proxy, are the least."
        )
    black = np.zeros((_SIDE_MIN_PX, _SIDE_MIN_PX, 3), np.float32)
    try:
        score(black, black)
    except InputError as error:
        raise InputError(f"{error}; or leave errors out: --truth-views 0") from error


def measure_errors(
    frames: BenchFrames,
    size: tuple[int, int],
    settings: DefocusSettings,
    truth_views: int,
    runs: int,
    say: Say,
) -> ErrorReport:
    """Measure time and error of each method on the truth scene.

    Plate methods get its pinhole picture.

    A method that was too slow once is left out from there on.
    """
    frame = frames.scene_frame(truth_scene(), wall_framing(size), LENS, settings)
    frame.renderer.look(
        frame.shot
    )  # now, so that it is not included in the time of the first method
    patience = Patience(runs, say)
    rows = []
    for coc in methods.METHOD_COC_PX:
        through = replace(frame, shot=replace(frame.shot, lens=truth_lens(coc, size[0])))
        rows.append(_row(through, coc, truth_views, patience, say))
    return ErrorReport(*size, bounded.LIMIT_S, truth_views, tuple(rows))


def _row(
    frame: SceneFrame, coc_px: float, truth_views: int, patience: Patience, say: Say
) -> ErrorRow:
    """Render the truth for one amount of blur and compare every method with it."""
    where = truth_where(coc_px)
    truth, truth_flip = truth_of(frame, truth_views, lambda done: say(f"{done}, {where}"))
    cells = {
        name: _cell(patience, name, _with(frame, asked), truth, where)
        for name, asked in entrants(frame.shot.defocus).items()
    }
    return ErrorRow(coc_px, truth_flip, cells)


def truth_where(coc_px: float) -> str:
    """Return the words after a truth or a method's name in progress messages."""
    return f"largest circle of confusion {coc_px:g} px"


def truth_words(views: int) -> str:
    """Return the progress message of a truth."""
    return f"truth from {views} views"


def truth_of(frame: SceneFrame, views: int, say: Say) -> tuple[FloatImage, float]:
    """Return the mean of `views` views, (H, W, 3) scene-linear, and the FLIP of half of them."""
    pictures = []
    for number in (max(views // 2, 1), views):  # the second continues the first
        settings = replace(frame.shot.defocus, method=Method.ACCUMULATION, views=number)
        pictures.append(_drawn(_with(frame, settings), number, say))
    half, whole = pictures
    return whole, score(half, whole).flip


def _drawn(frame: SceneFrame, views: int, say: Say) -> FloatImage:
    """Render the picture with the lens of the shot; report progress every _SAY_EVERY views."""
    say(truth_words(views))
    views_done = count(1)

    def tell(step: str) -> None:
        if step == "view" and (done := next(views_done)) % _SAY_EVERY == 0:
            say(f"truth, {done} views more")

    return _rgb(download(drained(frame.renderer.steps(frame.shot), tell)))


def _cell(
    patience: Patience, name: str, frame: Frame, truth: FloatImage, where: str
) -> ErrorCell | None:
    timed = patience.timed(name, lambda: frame, where)
    if timed is None:
        return None
    found = score(_rgb(download(timed.picture)), truth)
    return ErrorCell(timed.ms, found.flip, found.psnr_db, found.ssim)


def _with(frame: SceneFrame, settings: DefocusSettings) -> SceneFrame:
    return replace(frame, shot=replace(frame.shot, defocus=settings))


def _rgb(rgba: FloatImage) -> FloatImage:
    return np.ascontiguousarray(rgba[..., :3])
