"""Measure the mean error of every method over frames of a scene, as a row of README's table."""

from dataclasses import dataclass, replace
from statistics import fmean

from heatlens.gpu.stopwatch import run_seconds
from heatlens.measure.bench.methods import entrants
from heatlens.measure.bench.pace import Step
from heatlens.measure.bench.timing import Say
from heatlens.measure.metrics import score
from heatlens.measure.study.measured import Subject, cut, from_views
from heatlens.model.shot.settings import DefocusSettings, Method

_TRUTH = "truth"
_VIEWS_OF_OTHERS = 8  # for the estimate: another method takes about as long as so many views


@dataclass(frozen=True, slots=True)
class PullErrors:
    """FLIP of each method to the truth of each frame, by the method's name.

    truth_views  number of points of the lens over which the truth is averaged
    """

    scene: str
    width: int
    height: int
    truth_views: int
    frames: tuple[int, ...]
    flip: dict[str, tuple[float, ...]]

    @property
    def mean(self) -> dict[str, float]:
        """The mean over the frames, by the method's name."""
        return {name: fmean(values) for name, values in self.flip.items()}


def pull_entrants(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Return the methods by name, without ray tracing, which converges to the same truth."""
    found = entrants(settings)
    return {n: asked for n, asked in found.items() if asked.method is not Method.RAYTRACED}


def pull_steps(subject: Subject, frames: tuple[int, ...], views: int) -> tuple[Step, ...]:
    """Plan the pictures, by the time that one view of the first frame takes here."""
    settings = subject.settings(Method.ACCUMULATION)
    subject.forget(settings)  # this draws one view as well
    view_s = run_seconds(subject.renderer.ctx, lambda: subject.draw(replace(settings, views=1)))
    costs = {
        name: asked.views if asked.method.needs_scene else _VIEWS_OF_OTHERS
        for name, asked in pull_entrants(settings).items()
    } | {_TRUTH: views}
    return tuple(
        Step(_words(name, frame), cost * view_s) for frame in frames for name, cost in costs.items()
    )


def measure_pull(subject: Subject, frames: tuple[int, ...], views: int, say: Say) -> PullErrors:
    """Render each method, and a truth of `views` views, at each frame of a scene."""
    rows = [_errors(replace(subject, frame=frame), views, say) for frame in frames]
    flip = {name: tuple(row[name] for row in rows) for name in rows[0]}
    plate = subject.plate.data_window
    return PullErrors(subject.name, plate.width, plate.height, views, frames, flip)


def pull_table(errors: PullErrors) -> str:
    """Return the means as a table in Markdown."""
    cells = [("scene", errors.scene)]
    cells += [(_title(name), f"{value:.3f}") for name, value in errors.mean.items()]
    heads, values = zip(*cells, strict=True)
    rows = (heads, ("---",) * len(heads), values)
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _words(name: str, frame: int) -> str:
    return f"frame {frame}, {name}"


def _title(name: str) -> str:
    method, _, views = name.partition(" ")
    return f"{method}, {views} views" if views else method


def _errors(subject: Subject, views: int, say: Say) -> dict[str, float]:
    """Return FLIP by method at one frame; the truth goes on where accumulation has stopped."""
    pictures = {}
    for name, settings in pull_entrants(subject.shot.defocus).items():
        say(_words(name, subject.frame))
        pictures[name] = subject.pixels(settings)
    say(_words(_TRUTH, subject.frame))
    truth = from_views(subject, views, lambda _: None)
    return {
        name: score(cut(pixels, truth.region), truth.pixels).flip
        for name, pixels in pictures.items()
    }
