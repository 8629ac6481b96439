"""Measure the mean error of every method over frames of a scene, as README's table."""

from dataclasses import dataclass, replace
from enum import StrEnum
from statistics import fmean

from heatlens.core.base.pace import Step
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.deliver.export.options import PinholeOptions
from heatlens.deliver.export.pinhole_plate import pinhole_plate
from heatlens.lab.measure.bench.methods import compared_methods
from heatlens.lab.measure.bench.timing import ReportProgress
from heatlens.lab.measure.metrics import score
from heatlens.lab.measure.study.measured import Subject, crop_color, from_views
from heatlens.media.plate.plate import FloatImage
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.stopwatch import run_seconds

_TRUTH = "truth"
_VIEWS_OF_OTHER_METHODS = 8  # for the estimate: another method takes about as long as so many views


class Input(StrEnum):
    """What a method blurs: the scene itself, or one picture of it with one depth a pixel.

    Scenes of small pictures are blurred at twice their size, which halves the error.
    """

    SCENE = "the scene"
    PLATE = "one flat plate"
    LARGER = "a plate twice as large, halved"


# Plates are measured at the size of the scene and at twice that size. A scene is drawn and blurred
# at twice its size, and so a flat plate of its own size has a larger error (FLIP 0.037, the scene
# 0.023); a plate of twice the size, halved, has 0.024.
_PLATE_SCALES = {Input.PLATE: 1, Input.LARGER: 2}


@dataclass(frozen=True, slots=True)
class PullErrors:
    """FLIP of each method to the truth of each frame, by what is blurred and the method's name.

    truth_views  number of points of the lens over which the truth is averaged
    """

    scene: str
    width: int
    height: int
    truth_views: int
    frames: tuple[int, ...]
    flip: dict[Input, dict[str, tuple[float, ...]]]

    @property
    def mean(self) -> dict[Input, dict[str, float]]:
        """The mean over the frames, by what is blurred and the method's name."""
        return {
            kind: {name: fmean(values) for name, values in row.items()}
            for kind, row in self.flip.items()
        }


def pull_methods(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Return the methods by name, without ray tracing, which converges to the same truth."""
    methods = compared_methods(settings)
    return {
        name: method_settings
        for name, method_settings in methods.items()
        if method_settings.method is not Method.RAYTRACED
    }


def pull_steps(subject: Subject, frames: tuple[int, ...], views: int) -> tuple[Step, ...]:
    """Plan the pictures, by the time that one view of the first frame takes here."""
    settings = subject.settings(Method.ACCUMULATION)
    subject.forget(settings)  # this draws one view as well
    view_s = run_seconds(subject.renderer.ctx, lambda: subject.draw(replace(settings, views=1)))
    costs = {
        (Input.SCENE, name): method_settings.views
        if method_settings.method.needs_scene
        else _VIEWS_OF_OTHER_METHODS
        for name, method_settings in pull_methods(settings).items()
    }
    for kind, scale in _PLATE_SCALES.items():
        costs |= {
            (kind, name): scale**2 * _VIEWS_OF_OTHER_METHODS for name in _plate_methods(settings)
        }
    costs[Input.SCENE, _TRUTH] = views
    return tuple(
        Step(_step_message(kind, name, frame), cost * view_s)
        for frame in frames
        for (kind, name), cost in costs.items()
    )


def measure_pull(
    subject: Subject, frames: tuple[int, ...], views: int, report_progress: ReportProgress
) -> PullErrors:
    """Render each method, and a truth of `views` views, at each frame of a scene."""
    plate_renderer = subject.renderer.make_sibling()
    rows = [
        _measure_frame(replace(subject, frame=frame), plate_renderer, views, report_progress)
        for frame in frames
    ]
    plate_renderer.unload()
    flip = {
        kind: {name: tuple(row[kind][name] for row in rows) for name in rows[0][kind]}
        for kind in Input
    }
    plate = subject.plate.data_window
    return PullErrors(
        scene=subject.name,
        width=plate.width,
        height=plate.height,
        truth_views=views,
        frames=frames,
        flip=flip,
    )


def pull_table(errors: PullErrors) -> str:
    """Return the mean errors as a table in Markdown.

    It has a row for each input and a column for each method; only the scene has all methods.
    """
    names = list(errors.mean[Input.SCENE])
    rows = [("blurred", *map(_title, names)), ("---",) * (len(names) + 1)]
    for kind, mean in errors.mean.items():
        rows.append((kind, *(f"{mean[name]:.3f}" if name in mean else "" for name in names)))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _step_message(kind: Input, name: str, frame: int) -> str:
    """Return the progress message of one picture."""
    return f"frame {frame}, {name}" + (f" of {kind}" if kind is not Input.SCENE else "")


def _title(name: str) -> str:
    """Return the heading of a method: its name, and its number of views if the name has one."""
    method, _, views = name.partition(" ")
    return f"{method}, {views} views" if views else method


def _plate_methods(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Return the methods that need no scene, by name."""
    candidates = pull_methods(settings).items()
    return {
        name: method_settings
        for name, method_settings in candidates
        if not method_settings.method.needs_scene
    }


def _measure_frame(
    subject: Subject, plate_renderer: FrameRenderer, views: int, report_progress: ReportProgress
) -> dict[Input, dict[str, float]]:
    """Return FLIP by method at one frame; the truth continues the views of accumulation.

    `plate_renderer` renders the plates.
    """
    pictures: dict[Input, dict[str, FloatImage]] = {
        kind: _blur_plate(subject, plate_renderer, kind, scale, report_progress)
        for kind, scale in _PLATE_SCALES.items()
    }
    pictures[Input.SCENE] = {}
    for name, settings in pull_methods(subject.shot.defocus).items():
        report_progress(_step_message(Input.SCENE, name, subject.frame))
        pictures[Input.SCENE][name] = subject.pixels(settings)
    report_progress(_step_message(Input.SCENE, _TRUTH, subject.frame))
    truth = from_views(subject, views, lambda _: None)
    return {
        kind: {
            name: score(crop_color(pixels, truth.region), truth.pixels).flip
            for name, pixels in by_method.items()
        }
        for kind, by_method in pictures.items()
    }


def _blur_plate(
    subject: Subject,
    plate_renderer: FrameRenderer,
    kind: Input,
    scale: int,
    report_progress: ReportProgress,
) -> dict[str, FloatImage]:
    """Blur a plate `scale` times as large by each method; return pictures of the subject's size."""
    framing = subject.shot.framing or Framing()
    width, height = scale * framing.width_px, scale * framing.height_px
    shot = replace(subject.shot, framing=replace(framing, width_px=width, height_px=height))
    plate = pinhole_plate(subject.renderer, shot, subject.frame, PinholeOptions(), subject.name)
    # A flat plate: nothing is known behind its surfaces, nor outside its picture.
    plate_renderer.load(replace(plate.in_memory(), fragments=None, with_border=None))
    plate_subject = replace(subject, renderer=plate_renderer)
    pictures = {}
    for name, settings in _plate_methods(shot.defocus).items():
        report_progress(_step_message(kind, name, subject.frame))
        pictures[name] = _reduce(plate_subject.pixels(settings), scale)
    return pictures


def _reduce(pixels: FloatImage, factor: int) -> FloatImage:
    """Return the picture reduced by `factor`: the means of squares of `factor` pixels a side."""
    height, width, count = pixels.shape
    squares = pixels.reshape(height // factor, factor, width // factor, factor, count)
    means: FloatImage = squares.mean(axis=(1, 3))
    return means
