"""A shot: a lens over frames, and how its blur is computed."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import ceil, floor

import numpy as np

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.model.curves.curve import Curve
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange, check_frames_per_second
from heatlens.core.model.curves.interpolation import Scale
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.focus.live_focus import LiveFocus
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import LensKit
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import check_marks
from heatlens.core.model.option import Values
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.look import Look, check_looks
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.timecode import Timecode, parse_timecode


@dataclass(frozen=True, slots=True)
class LensCurves:
    """The keys of each parameter. Only the focus has a choice of scale: dioptres or meters.

    A focus that follows marks, `live`, takes the place of its keys once it has been measured.
    """

    focus_distance_m: Curve = field(default_factory=lambda: Curve(scale=Scale.RECIPROCAL))
    f_stop: Curve = field(default_factory=lambda: Curve(scale=Scale.LOGARITHMIC))
    focal_length_mm: Curve = field(default_factory=lambda: Curve(scale=Scale.LOGARITHMIC))
    squeeze: Curve = field(default_factory=Curve)
    tilt_deg: Curve = field(default_factory=Curve)
    split_dioptres: Curve = field(default_factory=Curve)
    live: LiveFocus | None = None

    def __post_init__(self) -> None:
        for parameter in LensParameter:
            scales = parameter.facts.scales
            if self.of(parameter).scale not in scales:
                raise InputError(f"Keys of {parameter} must use the {' or '.join(scales)} scale.")

    def of(self, parameter: LensParameter) -> Curve:
        """Return the curve of one parameter; it has no keys where the parameter is constant."""
        curve: Curve = getattr(self, parameter)
        return curve


@dataclass(frozen=True, slots=True)
class Shot:
    """A shot is a value: the same shot and frame give the same picture.

    lens               the values of the parameters that have no keys, and all else about the lens
    source             pattern of the plate's files or name of a scene, None where there is neither
    framing            the view of a scene; plates do not use it
    plate_options      how plates are read
    curves             keys; they override the values in `lens`
    marks              focus marks, in the order they were set
    frames             those of the plate, None where they are not known
    in_out             the part of them that is played and exported, None for all
    frames_per_second  when played
    looks              saved lenses, in the order in which they were saved
    kit                limits the values of the lens; None for no limits
    start_timecode     timecode of the first frame; None: from the headers of the plates
    grade              applied before the view, in what is made for the eye; None for none

    Raises InputError for two marks of one name, and for an impossible rate or source name.
    """

    lens: Lens
    defocus: DefocusSettings = field(default_factory=DefocusSettings)
    source: str | None = None
    plate_options: PlateOptions = field(default_factory=PlateOptions)
    curves: LensCurves = field(default_factory=LensCurves)
    marks: tuple[Mark, ...] = ()
    frames: FrameRange | None = None
    in_out: FrameRange | None = None
    frames_per_second: float = FRAMES_PER_SECOND
    framing: Framing | None = None
    looks: tuple[Look, ...] = ()
    kit: LensKit | None = None
    start_timecode: str | None = None
    grade: Grade | None = None

    def __post_init__(self) -> None:
        check_marks(self.marks)
        check_looks(self.looks)
        check_frames_per_second(self.frames_per_second)
        if self.start_timecode is not None:
            parse_timecode(self.start_timecode)
        if self.source is not None and (not self.source or "\0" in self.source):
            raise InputError(
                f"The plate of a shot is named {self.source!r}, which cannot be a file."
            )

    @property
    def missing_marks(self) -> list[str]:
        """The names of marks that the focus should follow and the shot does not have."""
        live = self.curves.live
        return [] if live is None else sorted({*live.marks} - {mark.name for mark in self.marks})

    @property
    def key_frames(self) -> tuple[float, ...]:
        """Every frame at which some parameter has a key, in order."""
        curves = (self.curves.of(parameter) for parameter in LensParameter)
        return tuple(sorted({key.frame for curve in curves for key in curve.keys}))

    @property
    def camera_key_frames(self) -> tuple[float, ...]:
        """Every frame at which the shot's own camera in a scene has a key; none while it stands."""
        track = None if self.framing is None else self.framing.track
        return tuple(key.frame for key in track.keys) if track and track.is_moving else ()

    @property
    def span(self) -> FrameRange | None:
        """The frames of the plate; if they are unknown, those from the first key to the last."""
        key_frames = self.key_frames
        if self.frames is not None or not key_frames:
            return self.frames
        return FrameRange(floor(key_frames[0]), ceil(key_frames[-1]))

    def with_start_timecode(self, text: str) -> "Shot":
        """Return the shot with the timecode of its first frame.

        Raises InputError for text that is not a timecode, or one that does not exist at its rate.
        """
        timecode = parse_timecode(text)
        problem = timecode.mismatch_message(self.frames_per_second)
        if problem:
            raise InputError(problem)
        return replace(self, start_timecode=str(timecode))

    def timecode_at(
        self, frame: int, header_timecode: Timecode | None = None, first_frame: int | None = None
    ) -> Timecode | None:
        """Return the timecode of a frame.

        `header_timecode` is that in the header of the frame's plate. `first_frame` is the first
        frame if the shot has none, because a still plate is shown at any frame. Returns None
        without a timecode, or for one that does not fit the rate.
        """
        if self.start_timecode is not None:
            first_frame = (
                self.span.first
                if self.span is not None
                else frame
                if first_frame is None
                else first_frame
            )
            start = parse_timecode(self.start_timecode)
            return _later_timecode(start, frame - first_frame, self.frames_per_second)
        return (
            None
            if header_timecode is None
            else _later_timecode(header_timecode, 0, self.frames_per_second)
        )

    @property
    def played_frames(self) -> FrameRange | None:
        """The frames from in to out if these are set, else all."""
        span = self.span
        if span is None or self.in_out is None:
            return span
        return span.intersection(self.in_out) or span

    def lens_at(self, frame: float) -> Lens:
        """Return the lens at a frame or between two.

        Raises LensError that names the frame if the keys make an impossible lens.
        """
        curves = {str(p): c for p in LensParameter if (c := self.curves.of(p)).keys}
        values: Values = {name: curve.value_at(frame) for name, curve in curves.items()}
        if self.curves.live is not None and self.curves.live.measured:
            values[LensParameter.FOCUS_DISTANCE.value] = self.focus_distance_at(frame)
        if not values:
            return self.lens
        try:
            return replace(self.lens, **values)
        except LensError as error:
            raise LensError(f"Frame {frame:g}: {error}") from None

    def focus_distance_at(self, frame: float) -> float:
        """Return the focus distance in meters at a frame, whether or not there is such a lens."""
        live, curve = self.curves.live, self.curves.focus_distance_m
        if live is not None and live.measured:
            track = _live_track(self.lens, self.curves, self.frames_per_second)
            return Scale.RECIPROCAL.value_at(float(np.interp(frame, live.frames, track)))
        return curve.value_at(frame) if curve.keys else self.lens.focus_distance_m

    def mark_named(self, name: str | None) -> Mark | None:
        """Return the mark of this name; None if the shot has no such mark."""
        return next((mark for mark in self.marks if mark.name == name), None)

    def with_look(self, look: Look) -> "Shot":
        """Return the shot as it is seen through the lens of a look, at every frame."""
        return replace(self, lens=look.lens, curves=LensCurves())

    def with_curve(self, parameter: LensParameter, curve: Curve) -> "Shot":
        """Return the shot with other keys for one parameter; focus keys remove the live focus."""
        changed_curves: Values = {str(parameter): curve}
        if parameter is LensParameter.FOCUS_DISTANCE and curve.keys:
            changed_curves["live"] = None
        return replace(self, curves=replace(self.curves, **changed_curves))

    def with_focus_scale(self, scale: Scale) -> "Shot":
        """Return the shot with the focus on another scale; its speed at each key stays.

        Raises InputError for meters if a key is at infinity.
        """
        return self.with_curve(
            LensParameter.FOCUS_DISTANCE, self.curves.focus_distance_m.convert_scale(scale)
        )

    def with_lens_value(
        self, frame: float, parameter: LensParameter, value: float, auto_key: bool = True
    ) -> "Shot":
        """Return the shot after a control was moved at a frame: the lens has the value there.

        Without keys for the parameter, it has the value at every frame. With keys, it is set at
        this frame; a new key is made only if `auto_key` allows it. Raises
        LensError for an impossible value, and InputError if a key would be needed.
        """
        curve = self.curves.of(parameter)
        if not curve.keys:
            lens_value: Values = {str(parameter): value}
            return replace(self, lens=replace(self.lens_at(frame), **lens_value))
        if curve.key_at(frame) is None and not auto_key:
            raise InputError(
                f"The {parameter.words} has keys, but none at frame {frame:g}: set one there, or "
                "switch auto key on."
            )
        return self.with_key(frame, parameter, value)

    def with_key(
        self, frame: float, parameter: LensParameter, value: float | None = None
    ) -> "Shot":
        """Return the shot with a key at a frame.

        If `value` is None, the value there becomes a key. Raises LensError for an impossible value,
        and InputError for the focus while it follows a mark.
        """
        if parameter is LensParameter.FOCUS_DISTANCE and self.curves.live is not None:
            raise InputError(
                f"The focus follows {self.curves.live.words}: before you set a key, make keys of "
                "what it follows, in the Marks tab."
            )
        if value is None:
            value = getattr(self.lens_at(frame), parameter)
        keyed_shot = self.with_curve(parameter, self.curves.of(parameter).with_value(frame, value))
        keyed_shot.lens_at(frame)  # raises LensError
        return keyed_shot

    def without_key(self, frame: float, parameter: LensParameter) -> "Shot":
        """Return the shot without the key at a frame.

        If it was the last key, its value applies at every frame.
        """
        curve = self.curves.of(parameter)
        key = curve.key_at(frame)
        if key is None:
            return self
        if len(curve.keys) == 1:
            return self.without_keys(frame, parameter)
        return self.with_curve(parameter, curve.without_keys((key.frame,)))

    def without_keys(self, frame: float, parameter: LensParameter) -> "Shot":
        """Return the shot without keys of a parameter; its value at `frame` stays everywhere."""
        constant_shot = replace(self, lens=self.lens_at(frame))
        return constant_shot.with_curve(parameter, replace(self.curves.of(parameter), keys=()))


@lru_cache(maxsize=32)
def _live_track(lens: Lens, curves: LensCurves, frames_per_second: float) -> list[float]:
    """Return the dioptres of the focus that follows, at each frame that was measured."""
    live = curves.live
    assert live is not None
    keyless_shot = Shot(lens, curves=replace(curves, live=None))
    return live.dioptres(live_sharp_dioptres(keyless_shot, live.frames), frames_per_second)


def live_sharp_dioptres(keyless_shot: Shot, frames: Iterable[int]) -> list[float]:
    """Return half the sharp range in dioptres at each frame, for a shot without a live focus.

    It hardly depends on the focus.
    """
    return [sharp_dioptres(keyless_shot.lens_at(frame)) for frame in frames]


def _later_timecode(timecode: Timecode, frames: int, frames_per_second: float) -> Timecode | None:
    """Return the timecode `frames` frames later; None if it does not fit the rate."""
    fits_rate = timecode.fits(frames_per_second)
    return timecode.add_frames(frames, frames_per_second) if fits_rate else None
