"""Measure the mean error of every method over frames of a scene, as README's table."""

from dataclasses import dataclass, replace
from enum import StrEnum
from statistics import fmean

from heatlens.core.base.pace import Step
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.deliver.export.pinhole_plate import PinholeOptions, pinhole_plate
from heatlens.lab.measure.bench.methods import entrants
from heatlens.lab.measure.bench.timing import Say
from heatlens.lab.measure.metrics import score
from heatlens.lab.measure.study.measured import Subject, cut, from_views
from heatlens.media.plate.plate import FloatImage
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.stopwatch import run_seconds

_TRUTH = "truth"
_VIEWS_OF_OTHERS = 8  # for the estimate: another method takes about as long as so many views


class Input(StrEnum):
    """What a method blurs: the scene itself, or one picture of it with one depth a pixel.

    Scenes of small pictures are blurred at twice their size, which halves the error.
    """

    SCENE = "the scene"
    PLATE = "one flat plate"
    LARGER = "a plate twice as large, halved"


# A scene is drawn and blurred at twice its size. Beside it a flat plate of its size looks worse
# than plates are (FLIP 0.037 to 0.023 of the scene); one of twice the size, halved, has 0.024.
_TIMES_LARGER = {Input.PLATE: 1, Input.LARGER: 2}


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


def pull_entrants(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Return the methods by name, without ray tracing, which converges to the same truth."""
    every = entrants(settings)
    return {n: asked for n, asked in every.items() if asked.method is not Method.RAYTRACED}


def pull_steps(subject: Subject, frames: tuple[int, ...], views: int) -> tuple[Step, ...]:
    """Plan the pictures, by the time that one view of the first frame takes here."""
    settings = subject.settings(Method.ACCUMULATION)
    subject.forget(settings)  # this draws one view as well
    view_s = run_seconds(subject.renderer.ctx, lambda: subject.draw(replace(settings, views=1)))
    costs = {
        (Input.SCENE, name): asked.views if asked.method.needs_scene else _VIEWS_OF_OTHERS
        for name, asked in pull_entrants(settings).items()
    }
    for kind, times in _TIMES_LARGER.items():
        costs |= {(kind, name): times**2 * _VIEWS_OF_OTHERS for name in _of_plates(settings)}
    costs[Input.SCENE, _TRUTH] = views
    return tuple(
        Step(_words(kind, name, frame), cost * view_s)
        for frame in frames
        for (kind, name), cost in costs.items()
    )


def measure_pull(subject: Subject, frames: tuple[int, ...], views: int, say: Say) -> PullErrors:
    """Render each method, and a truth of `views` views, at each frame of a scene."""
    flat = subject.renderer.beside()
    rows = [_errors(replace(subject, frame=frame), flat, views, say) for frame in frames]
    flat.let_go()
    flip = {
        kind: {name: tuple(row[kind][name] for row in rows) for name in rows[0][kind]}
        for kind in Input
    }
    plate = subject.plate.data_window
    return PullErrors(subject.name, plate.width, plate.height, views, frames, flip)


def pull_table(errors: PullErrors) -> str:
    """Return the means as a table in Markdown."""
    names = list(errors.mean[Input.SCENE])
    rows = [("blurred", *map(_title, names)), ("---",) * (len(names) + 1)]
    for kind, mean in errors.mean.items():
        rows.append((kind, *(f"{mean[name]:.3f}" if name in mean else "" for name in names)))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _words(kind: Input, name: str, frame: int) -> str:
    return f"frame {frame}, {name}" + (f" of {kind}" if kind is not Input.SCENE else "")


def _title(name: str) -> str:
    method, _, views = name.partition(" ")
    return f"{method}, {views} views" if views else method


def _of_plates(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Return the methods that need no scene, by name."""
    candidates = pull_entrants(settings).items()
    return {name: asked for name, asked in candidates if not asked.method.needs_scene}


def _errors(
    subject: Subject, flat: FrameRenderer, views: int, say: Say
) -> dict[Input, dict[str, float]]:
    """Return FLIP by method at one frame; the truth goes on where accumulation has stopped.

    `flat` renders plates.
    """
    pictures: dict[Input, dict[str, FloatImage]] = {
        kind: _of_plate(subject, flat, kind, times, say) for kind, times in _TIMES_LARGER.items()
    }
    pictures[Input.SCENE] = {}
    for name, settings in pull_entrants(subject.shot.defocus).items():
        say(_words(Input.SCENE, name, subject.frame))
        pictures[Input.SCENE][name] = subject.pixels(settings)
    say(_words(Input.SCENE, _TRUTH, subject.frame))
    truth = from_views(subject, views, lambda _: None)
    return {
        kind: {
            name: score(cut(pixels, truth.region), truth.pixels).flip
            for name, pixels in by_method.items()
        }
        for kind, by_method in pictures.items()
    }


def _of_plate(
    subject: Subject, flat: FrameRenderer, kind: Input, times: int, say: Say
) -> dict[str, FloatImage]:
    """Return the picture by each method of a plate `times` as large, at the size of the subject."""
    framing = subject.shot.framing or Framing()
    width, height = times * framing.width_px, times * framing.height_px
    shot = replace(subject.shot, framing=replace(framing, width_px=width, height_px=height))
    plate = pinhole_plate(subject.renderer, shot, subject.frame, PinholeOptions(), subject.name)
    flat.load(replace(plate.in_memory(), fragments=None, beyond=None))
    of_plate = replace(subject, renderer=flat)
    pictures = {}
    for name, settings in _of_plates(shot.defocus).items():
        say(_words(kind, name, subject.frame))
        pictures[name] = _reduced(of_plate.pixels(settings), times)
    return pictures


def _reduced(pixels: FloatImage, times: int) -> FloatImage:
    """Return the means of squares of `times` pixels a side."""
    height, width, count = pixels.shape
    squares = pixels.reshape(height // times, times, width // times, times, count)
    means: FloatImage = squares.mean(axis=(1, 3))
    return means
