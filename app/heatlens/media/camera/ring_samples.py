"""Convert a camera's lens to the samples that are sent during playback."""

from collections.abc import Callable

from heatlens.core.model.option import Values
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.media.camera.samples import CameraSamples, finite_m
from heatlens.media.live.ring.sources import LensSample


def ring_samples(
    camera: CameraSamples, timecode_at: Callable[[int], Timecode | None]
) -> tuple[LensSample, ...]:
    """Return a sample for each frame, with the nominal f-stop, as marked on the lens ring.

    `timecode_at` returns the timecode of a frame, if it has one.
    """
    return tuple(_sample(camera, index, timecode_at) for index in range(len(camera.frames)))


def _sample(
    camera: CameraSamples, index: int, timecode_at: Callable[[int], Timecode | None]
) -> LensSample:
    """Return the sample of the frame with this index."""
    tracks = {
        "focus_distance_m": camera.focus_distance_m,
        "f_stop": camera.nominal_f_stop or camera.f_stop,
        "focal_length_mm": camera.focal_length_mm,
    }
    values: Values = {
        name: finite_m(track[index]) for name, track in tracks.items() if track is not None
    }
    frame, rate = camera.frames[index], camera.frames_per_second
    timecode = timecode_at(frame) or time_of_frame(frame, rate)
    return LensSample(camera.name, **values, timecode=timecode, frames_per_second=rate)


def sample_of_shot(name: str, shot: Shot, frame: int, timecode: Timecode | None) -> LensSample:
    """Return the sample of a shot's lens at a frame, sent by the source called `name`.

    `timecode` is that of the frame, if it has one.
    """
    lens, rate = shot.lens_at(frame), shot.frames_per_second
    return LensSample(
        name,
        focus_distance_m=finite_m(lens.focus_distance_m),
        f_stop=lens.f_stop,
        t_stop=lens.t_stop,
        focal_length_mm=lens.focal_length_mm,
        timecode=timecode or time_of_frame(frame, rate),
        frames_per_second=rate,
    )


def time_of_frame(frame: int, frames_per_second: float) -> Timecode | None:
    """Return the timecode of a frame that is counted from midnight; None before frame 0."""
    timecode = Timecode(0, 0, 0, 0).add_frames(max(frame, 0), max(frames_per_second, 1.0))
    return timecode if frame >= 0 and timecode.is_possible else None
