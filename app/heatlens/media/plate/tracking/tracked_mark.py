"""Follow the surface of a mark through all frames, forwards and backwards from each click."""

from collections.abc import Callable, Iterable

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.marks.track_mark import Click, TrackMark, TrackPlace
from heatlens.media.plate.coc_line import no_distances
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.tracking.surface_tracker import Sight, SurfaceTracker

PlateAt = Callable[[int], Plate]


def tracked(
    mark: TrackMark, frames: FrameRange, plate_at: PlateAt, show: Callable[[str], None]
) -> TrackMark:
    """Return the mark with its place at each frame; `show` is told how far it is.

    Between two clicks it is followed from both, and each counts the more the nearer it is. Raises
    InputError for a click outside the frames or the picture, or on the sky, and for plates without
    distances.
    """
    for click in mark.clicks:
        if click.frame not in frames:
            raise InputError(f"Mark {mark.name}: frame {click.frame} is not among {frames}.")

    def followed(click: Click, onward: Iterable[int]) -> dict[int, Sight]:
        show(f"following {mark.name} from frame {click.frame} of {frames}")
        return _followed(click, onward, plate_at)

    ends = [frames.first, *(click.frame for click in mark.clicks), frames.last]
    places: dict[int, TrackPlace] = {}
    later: dict[int, Sight] = {}
    for at, click in enumerate(mark.clicks):
        earlier = followed(click, range(click.frame, ends[at] - 1, -1))
        for frame in sorted({*earlier, *later}):
            place = _between(frame, (ends[at], later), (click.frame, earlier))
            places[frame] = place
        later = followed(click, range(click.frame, ends[at + 2] + 1))
    places |= {frame: _placed(frame, sight) for frame, sight in later.items()}
    track = tuple(places[frame] for frame in sorted(places))
    return TrackMark(mark.name, mark.clicks, track)


def _followed(click: Click, onward: Iterable[int], plate_at: PlateAt) -> dict[int, Sight]:
    """Return what is seen of the surface at each frame, of which that of the click is the first."""
    plate = plate_at(click.frame)
    if not plate.has_distances:
        raise no_distances(plate)
    tracker = SurfaceTracker(plate, click.x_px, click.y_px)
    sights = {click.frame: tracker.sight}
    return sights | {
        frame: tracker.step(plate_at(frame)) for frame in onward if frame != click.frame
    }


def _between(
    frame: int, later: tuple[int, dict[int, Sight]], earlier: tuple[int, dict[int, Sight]]
) -> TrackPlace:
    """Return the place between two clicks from what was seen going on from either."""
    (start, forward), (end, backward) = later, earlier
    one, other = forward.get(frame), backward.get(frame)
    if one is None or other is None or (one.dioptres is None) != (other.dioptres is None):
        seen = [it for it in (one, other) if it is not None and it.dioptres is not None]
        return _placed(frame, seen[0] if seen else one or other)
    part = (frame - start) / (end - start) if end > start else 1.0

    def mixed(a: float, b: float) -> float:
        return a + part * (b - a)

    dioptres = None
    if one.dioptres is not None and other.dioptres is not None:
        dioptres = mixed(one.dioptres, other.dioptres)
    x, y = mixed(one.x, other.x), mixed(one.y, other.y)
    return _placed(frame, Sight(x, y, dioptres, min(one.likeness, other.likeness)))


def _placed(frame: int, sight: Sight | None) -> TrackPlace:
    assert sight is not None
    distance_m = None if sight.dioptres is None else 1.0 / sight.dioptres
    return TrackPlace(
        frame, round(sight.x, 2), round(sight.y, 2), distance_m, round(sight.likeness, 3)
    )
