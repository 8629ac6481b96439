"""Keep frames of a movie in lossless files beside it until one export joins them.

Several machines can make a movie like this. The files hold the 16 bits that the encoder would get,
so the movie is the same as one that a single machine makes.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.deliver.export.finished import is_finished, is_movie_finished
from heatlens.deliver.export.frame_files import MOVIE_WHITE, RenderedFrame
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame, kept_path, plan_export
from heatlens.deliver.export.rendering import FrameRendering
from heatlens.media.files.marks import JOB_ATTRIBUTE
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_write import write_exr
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.picture.picture_write import quantize
from heatlens.render.frame_renderer import FrameRenderer

_CHANNELS = "RGB"


def is_movie_joined(plan: ExportPlan) -> bool:
    """Return True if the plan makes frames for a movie that is complete already."""
    job, path = plan.job, plan.job.output.path_at(0)
    if not (plan.is_part and job.output.is_movie) or job.options.force or not path.exists():
        return False
    return is_movie_finished(path, plan_export(job).movie_fingerprint)


# The files hold the levels that the encoder would get, not the picture in 16 bits. Such a picture
# would be quantized twice, and a joined movie would differ in its last bits from one that a single
# machine makes.
def write_kept_frame(frame: RenderedFrame) -> None:
    """Write the encoder levels of a frame to its own EXR file. Raises InputError if that fails."""
    values = quantize(frame.pixels, np.uint16, MOVIE_WHITE).astype(np.uint32)
    window = Box(0, 0, values.shape[1], values.shape[0])
    write_exr(
        frame.planned.path,
        {},
        window,
        window,
        frame.plate.pixel_aspect_ratio,
        {**frame.plate.attributes, JOB_ATTRIBUTE: frame.planned.fingerprint},
        unchanged={name: values[..., i] for i, name in enumerate(_CHANNELS)},
    )


def remove_kept_frames(plan: ExportPlan) -> None:
    """Delete the files of the frames, which the movie has replaced."""
    with suppress(OSError):  # those that stay do no harm
        for frame in plan.frames:
            kept_path(frame.path, frame.frame).unlink(missing_ok=True)
        kept_path(plan.frames[0].path, 0).parent.rmdir()


class KeptFrameRendering:
    """Gives the frames of a movie: read from kept files, or rendered if there is no file."""

    def __init__(
        self,
        plan: ExportPlan,
        frames: tuple[PlannedFrame, ...],
        make_renderer: Callable[[], FrameRenderer],
    ) -> None:
        """Find the complete kept files; `make_renderer` is called only if one is missing."""
        files = (replace(frame, path=kept_path(frame.path, frame.frame)) for frame in frames)
        self._kept_paths = {frame.frame: frame.path for frame in files if is_finished(frame)}
        missing_frames = tuple(frame for frame in frames if frame.frame not in self._kept_paths)
        self._rendering = (
            FrameRendering(plan, missing_frames, make_renderer()) if missing_frames else None
        )

    def render(self, frame: PlannedFrame) -> RenderedFrame:
        """Return the frame. Raises InputError as `FrameRendering.render` does."""
        path = self._kept_paths.get(frame.frame)
        if path is not None:
            return read_kept_frame(path, frame)
        assert self._rendering is not None
        return self._rendering.render(frame)

    def close(self) -> None:
        """Stop rendering."""
        if self._rendering is not None:
            self._rendering.close()


def read_kept_frame(path: Path, frame: PlannedFrame) -> RenderedFrame:
    """Return a frame from its kept file.

    Its plate is a stand-in of one pixel, with only the header that a movie needs.
    """
    ((header, channels),) = read_parts(path)
    plate = replace(
        plate_of_arrays(np.zeros((1, 1, 3), np.float32), np.ones((1, 1), np.float32)),
        path=path,
        pixel_aspect_ratio=header["pixelAspectRatio"],
        attributes=header,
    )
    values = np.stack([channels[name] for name in _CHANNELS], axis=-1)
    pixels = values.astype(np.float32) / np.float32(MOVIE_WHITE)
    return RenderedFrame(frame, plate, pixels, is_kept=True)
