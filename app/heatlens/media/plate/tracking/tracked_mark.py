"""Follow the surface of a mark through all frames, forwards and backwards from each click."""

from collections.abc import Callable, Iterable

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.marks.track_mark import Click, TrackedPoint, TrackMark
from heatlens.media.plate.coc_line import no_distances_error
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.tracking.surface_tracker import Sight, SurfaceTracker

PlateAt = Callable[[int], Plate]


def track_mark(
    mark: TrackMark, frames: FrameRange, plate_at: PlateAt, report_progress: Callable[[str], None]
) -> TrackMark:
    """Return the mark with its place at each frame.

    `plate_at` returns the plate of a frame. `report_progress` gets a sentence for each click.
    Between two clicks the surface is followed from both, and the nearer click has the larger
    weight. Raises InputError for a click outside the frames or the picture, or on the sky, and for
    plates without distances.
    """
    for click in mark.clicks:
        if click.frame not in frames:
            raise InputError(f"Mark {mark.name}: frame {click.frame} is not among {frames}.")

    def follow_click(click: Click, next_frames: Iterable[int]) -> dict[int, Sight]:
        report_progress(f"following {mark.name} from frame {click.frame} of {frames}")
        return _follow_surface(click, next_frames, plate_at)

    ends = [frames.first, *(click.frame for click in mark.clicks), frames.last]
    points: dict[int, TrackedPoint] = {}
    forward_sights: dict[int, Sight] = {}
    for index, click in enumerate(mark.clicks):
        backward_sights = follow_click(click, range(click.frame, ends[index] - 1, -1))
        for frame in sorted({*backward_sights, *forward_sights}):
            point = _blend_sights(
                frame, (ends[index], forward_sights), (click.frame, backward_sights)
            )
            points[frame] = point
        forward_sights = follow_click(click, range(click.frame, ends[index + 2] + 1))
    points |= {frame: _tracked_point(frame, sight) for frame, sight in forward_sights.items()}
    track = tuple(points[frame] for frame in sorted(points))
    return TrackMark(mark.name, mark.clicks, track)


def _follow_surface(
    click: Click, next_frames: Iterable[int], plate_at: PlateAt
) -> dict[int, Sight]:
    """Return the sight of the surface at each frame, beginning with the frame of the click."""
    plate = plate_at(click.frame)
    if not plate.has_distances:
        raise no_distances_error(plate)
    tracker = SurfaceTracker(plate, x=click.x_px, y=click.y_px)
    sights = {click.frame: tracker.sight}
    return sights | {
        frame: tracker.step(plate_at(frame)) for frame in next_frames if frame != click.frame
    }


def _blend_sights(
    frame: int,
    forward_track: tuple[int, dict[int, Sight]],
    backward_track: tuple[int, dict[int, Sight]],
) -> TrackedPoint:
    """Return the place at a frame between two clicks, blended from the sights from both clicks.

    Each track is the frame of its click, and the sights by frame.
    """
    (start, forward), (end, backward) = forward_track, backward_track
    forward_sight, backward_sight = forward.get(frame), backward.get(frame)
    if (
        forward_sight is None
        or backward_sight is None
        or (forward_sight.dioptres is None) != (backward_sight.dioptres is None)
    ):
        visible_sights = [
            sight
            for sight in (forward_sight, backward_sight)
            if sight is not None and sight.dioptres is not None
        ]
        return _tracked_point(
            frame, visible_sights[0] if visible_sights else forward_sight or backward_sight
        )
    share = (frame - start) / (end - start) if end > start else 1.0

    def interpolate(a: float, b: float) -> float:
        return a + share * (b - a)

    dioptres = None
    if forward_sight.dioptres is not None and backward_sight.dioptres is not None:
        dioptres = interpolate(forward_sight.dioptres, backward_sight.dioptres)
    x = interpolate(forward_sight.x, backward_sight.x)
    y = interpolate(forward_sight.y, backward_sight.y)
    return _tracked_point(
        frame, Sight(x, y, dioptres, min(forward_sight.likeness, backward_sight.likeness))
    )


def _tracked_point(frame: int, sight: Sight | None) -> TrackedPoint:
    """Return a sight as the place of a mark at a frame, rounded."""
    assert sight is not None
    distance_m = None if sight.dioptres is None else 1.0 / sight.dioptres
    return TrackedPoint(
        frame, round(sight.x, 2), round(sight.y, 2), distance_m, round(sight.likeness, 3)
    )
