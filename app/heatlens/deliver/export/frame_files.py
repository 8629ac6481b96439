"""Write a rendered frame to its file: an EXR with all requested channels, or a display picture."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import exact_rate
from heatlens.core.model.focus.coc import coc_px, focus_offset_coc_px
from heatlens.core.model.timecode import Timecode
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.options import ExportOptions
from heatlens.deliver.export.plan import PlannedFrame
from heatlens.deliver.export.sequence_check import Remark
from heatlens.media.files.marks import JOB_ATTRIBUTE, blurred_mark
from heatlens.media.plate.coc_line import line_of
from heatlens.media.plate.deep.deep_write import write_deep
from heatlens.media.plate.header.timecode import exr_timecode, timecode_of
from heatlens.media.plate.kept_channels import read_kept_channels
from heatlens.media.plate.picture.picture_write import (
    lens_header,
    write_display_values,
    write_picture,
)
from heatlens.media.plate.plate import FloatImage, Plate

MOVIE_WHITE = 65280  # 255 times 256, which FFmpeg takes as white in 16 bits


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """A frame on its way to its file.

    pixels   EXR: light, (H, W, 4) premultiplied; else display values 0..1, (H, W, 3)
    remarks  differences between the plate and those of earlier frames
    pace     message on the render time of the quality final, where it was measured
    is_kept  read from the file of an earlier export, not rendered
    """

    planned: PlannedFrame
    plate: Plate
    pixels: FloatImage
    remarks: tuple[Remark, ...] = ()
    pace: str = ""
    is_kept: bool = False


def write_frame(job: ExportJob, frame: RenderedFrame) -> None:
    """Write a numbered file. Raises InputError if that fails; an existing file then stays."""
    if job.pinhole and job.pinhole_options.deep:
        _write_deep(job, frame)
    elif job.output.is_exr:
        _write_exr(job, frame)
    else:
        _write_display_picture(frame, blurred_mark(not job.pinhole))


def _write_exr(job: ExportJob, frame: RenderedFrame) -> None:
    """Write a rendered frame as EXR, with the channels and header entries to keep."""
    proxy = job.shot.defocus.proxy
    plate_channels, attributes = _plate_channels_to_keep(job, frame)
    write_picture(
        frame.planned.path,
        frame.pixels,
        frame.plate,
        frame.planned.lens,
        proxy,
        half=not job.options.is_float,
        compression=job.options.compression,
        more_channels=measure_channels(frame, proxy, job.options),
        more_attributes={
            **attributes,
            JOB_ATTRIBUTE: frame.planned.fingerprint,
            "framesPerSecond": exact_rate(job.shot.frames_per_second),
            **_timecode_attribute(job, frame),
        },
        kept_channels=plate_channels,
        is_blurred=not job.pinhole,
    )


def _write_deep(job: ExportJob, frame: RenderedFrame) -> None:
    """Write a frame before the lens as a deep EXR."""
    plate, planned = frame.plate, frame.planned
    attributes = {
        **plate.attributes,
        **lens_header(plate, planned.lens),
        **blurred_mark(is_blurred=False),
        JOB_ATTRIBUTE: planned.fingerprint,
        "framesPerSecond": exact_rate(job.shot.frames_per_second),
    }
    write_deep(planned.path, plate, attributes, half=not job.options.is_float)


def _plate_channels_to_keep(
    job: ExportJob, frame: RenderedFrame
) -> tuple[dict[str, NDArray[np.generic]], dict[str, Any]]:
    """Return the result of `kept_channels`; a black frame keeps no channels of the plate."""
    channel_names = () if frame.planned.origin.is_black else job.keep
    return read_kept_channels(frame.plate, job.shot.plate_options, channel_names)


def frame_timecode(job: ExportJob, planned: PlannedFrame, plate: Plate) -> Timecode | None:
    """Return the timecode of the shot, else of the plate.

    If another plate replaces that of the frame, its timecode is advanced to the frame. Returns None
    if there is no timecode, or it does not fit the rate.
    """
    shot, frame = job.shot, planned.frame
    timecode = shot.timecode_at(frame, timecode_of(plate.attributes), min(job.frames))
    if timecode is None or shot.start_timecode is not None:
        return timecode
    return timecode.add_frames(frame - planned.origin.frame, shot.frames_per_second)


def _timecode_attribute(job: ExportJob, frame: RenderedFrame) -> dict[str, object]:
    """Return the header attribute of the timecode; {} for a frame without one."""
    timecode = frame_timecode(job, frame.planned, frame.plate)
    value = None if timecode is None else exr_timecode(timecode)
    return {} if value is None else {"timeCode": value}


def measure_channels(
    frame: RenderedFrame, proxy: float, options: ExportOptions
) -> dict[str, FloatImage]:
    """Return the channels Z and coc that the options request: depth and blur of each pixel.

    Z is in meters, coc (circle of confusion) in pixels; both are (H, W), of the plate before the
    blur, sampled to the size of the picture. Raises InputError.
    """
    plate, channels = frame.plate, {}
    if options.with_depth:
        if plate.depth_m is None:
            raise InputError(
                f"{plate.path} holds circles of confusion and no depth: leave --with-depth out."
            )
        channels["Z"] = _sample_at_pixels(plate.depth_m, frame.pixels.shape)
    if options.with_coc:
        channels["coc"] = np.float32(proxy) * _sample_at_pixels(
            _full_size_coc_px(frame), frame.pixels.shape
        )
    return channels


def _full_size_coc_px(frame: RenderedFrame) -> FloatImage:
    """Return the circle of confusion of each pixel of the plate, in pixels at full size."""
    plate = frame.plate
    if plate.coc_px is not None:
        return plate.coc_px
    assert plate.depth_m is not None
    line, window = line_of(plate, frame.planned.lens), plate.data_window
    tilt_coc_px = focus_offset_coc_px(line, Box(0, 0, window.width, window.height))
    return (coc_px(plate.depth_m, line) + tilt_coc_px).astype(np.float32)


def _sample_at_pixels(values: FloatImage, shape: tuple[int, ...]) -> FloatImage:
    """Resize (H, W) values to the middle pixel of each footprint, as the renderer does."""
    rows, columns = (
        ((np.arange(small) + 0.5) * (full / small)).astype(int)
        for small, full in zip(shape[:2], values.shape, strict=True)
    )
    sampled: FloatImage = values[rows[:, None], columns]
    return sampled


def _write_display_picture(frame: RenderedFrame, attributes: dict[str, str]) -> None:
    """Write a display picture with the fingerprint of the frame and other attributes."""
    write_display_values(
        frame.planned.path, frame.pixels, {JOB_ATTRIBUTE: frame.planned.fingerprint} | attributes
    )
