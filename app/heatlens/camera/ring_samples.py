"""Convert a camera's lens to the samples that are sent during playback."""

from typing import Any

from heatlens.camera.samples import CameraSamples, finite_m
from heatlens.model.lens import Lens
from heatlens.ring.lens_sample import LensSample


def ring_samples(camera: CameraSamples) -> tuple[LensSample, ...]:
    """Return a sample for each frame, with the nominal f-stop, as marked on the lens ring."""
    return tuple(_sample(camera, at) for at in range(len(camera.frames)))


def _sample(camera: CameraSamples, at: int) -> LensSample:
    tracks = {
        "focus_distance_m": camera.focus_distance_m,
        "f_stop": camera.nominal_f_stop or camera.f_stop,
        "focal_length_mm": camera.focal_length_mm,
    }
    values: dict[str, Any] = {
        name: finite_m(track[at]) for name, track in tracks.items() if track is not None
    }
    time = time_of_frame(camera.frames[at], camera.frames_per_second)
    return LensSample(camera.name, **values, timecode=time)


def sample_of_lens(name: str, lens: Lens, frame: int, frames_per_second: float) -> LensSample:
    """Return the sample of a lens at a frame, sent by the source called `name`."""
    return LensSample(
        name,
        focus_distance_m=finite_m(lens.focus_distance_m),
        f_stop=lens.f_stop,
        t_stop=lens.t_stop,
        focal_length_mm=lens.focal_length_mm,
        timecode=time_of_frame(frame, frames_per_second),
    )


def time_of_frame(frame: int, frames_per_second: float) -> tuple[int, int, int, int] | None:
    """Return the frame as hours, minutes, seconds and frames; None before frame 0.

    Timecode counts whole frames a second, as SMPTE ST 12-1 does without dropping: 24 at 23.976.
    """
    if frame < 0:
        return None
    seconds, frames = divmod(frame, max(round(frames_per_second), 1))
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return hours % 24, minutes, seconds, frames
