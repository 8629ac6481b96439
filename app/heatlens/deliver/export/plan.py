"""Plan an export: the inputs, the file and the fingerprint of each frame.

The fingerprint is a digest of everything that decides the pixels. A frame is finished if its file
holds the fingerprint of the same plate or scene, lens and options; an existing file alone is not
enough. Plates, depth files, scenes and the files that scenes name are identified by time and size,
looked up before they are read, so that a file that is written meanwhile is rendered again. The
scene that comes with the program is identified by its version.
"""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import BLUR_EDITION
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import NO_GUIDES
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.options import (
    EXR,
    LOOK,
    ExportOptions,
    PinholeOptions,
    options_of_group,
)
from heatlens.deliver.export.output import check_names
from heatlens.media.files.json_record import digest, to_json
from heatlens.media.files.picture_formats import file_on_disk
from heatlens.media.plate.exr.exr_whole import find_incomplete
from heatlens.media.sequence.names import parse_frames
from heatlens.render.source.named import source_of
from heatlens.render.source.source import Origin, Source
from heatlens.version import __version__

_MOST_NAMED_FILES = 5  # most files named in a sentence
# Increased when the same frames give another movie: 1 had wrong pixels, 2 was 0.4 % too bright.
_MOVIE_ENCODING = 3

_FIRST_FIELDS = {"is_float", "compression", "with_depth", "with_coc", "keep_channels"} | {
    *("burn_in", "unit", "burn_in_text", "shot_name")
}


@dataclass(frozen=True)
class PlannedFrame:
    """A frame before it is rendered.

    fingerprint  identifies everything that decides the pixels; it is kept in the file
    """

    frame: int
    origin: Origin
    lens: Lens
    path: Path
    fingerprint: str


@dataclass(frozen=True)
class ExportPlan:
    """The frames of a job with their inputs, or a part of them.

    is_part  True if only some frames of the job are planned; those of a movie get their own files
    """

    job: ExportJob
    source: Source
    frames: tuple[PlannedFrame, ...]
    is_part: bool = False

    @property
    def makes_movie(self) -> bool:
        """True if all frames go into one file."""
        return self.job.output.is_movie and not self.is_part

    @property
    def folder(self) -> Path:
        """The folder that the files are written to."""
        return self.frames[0].path.parent

    @property
    def movie_fingerprint(self) -> str:
        """The fingerprint of a movie of all frames."""
        rate = self.job.shot.frames_per_second
        return fingerprint_of_movie([frame.fingerprint for frame in self.frames], rate)


def frames_of(shot: Shot, text: str | None) -> tuple[int, ...]:
    """Return the frames in `text`, such as 1001-1100x2, or if None those from in to out, else all.

    Raises InputError if the text is not a frame range or the source is not found.
    """
    return source_of(shot).frames_of(shot) if text is None else parse_frames(text)


def kept_path(movie: Path, frame: int) -> Path:
    """Return the lossless file of a frame of a movie, in a folder beside the movie."""
    return movie.with_name(f"{movie.name}.frames") / f"frame.{frame:04d}.exr"


def plan_export(job: ExportJob, subset: Sequence[int] | None = None) -> ExportPlan:
    """Return the plan of a job. Input files are looked up, but nothing is written.

    With `subset`, only these frames are planned; the files of a movie's frames are then those of
    `kept_path`. Raises InputError if a scene is missing, if a plate is missing and the job does not
    allow to replace it, if an output would overwrite an input, or if the lens is impossible.
    """
    source, frames = source_of(job.shot), job.frames if subset is None else subset
    source.check(job.shot, tuple(frames), job.options.missing)
    is_part = subset is not None
    check_names(job.output, job.frames, has_folder=not is_part)
    planned_frames = tuple(_plan_frame(job, source, frame, is_part) for frame in frames)
    plan = ExportPlan(job, source, planned_frames, is_part)
    _check_inputs_not_overwritten(plan)
    _check_plates_complete(plan)
    return plan


def _plan_frame(job: ExportJob, source: Source, frame: int, is_part: bool) -> PlannedFrame:
    """Return the inputs, the file and the fingerprint of one frame."""
    lens = job.shot.lens_at(frame)
    origin = source.origin(job.shot, frame, job.options.missing)
    fingerprint = fingerprint_of(job, frame, lens, origin)
    path = job.output.path_at(frame)
    path = kept_path(path, frame) if is_part and job.output.is_movie else path
    return PlannedFrame(frame, origin, lens, path, fingerprint)


# A file that was cut short still has a valid header. Without this check, it would fail only when
# its frame is rendered. Headers, tables of chunks and lengths are enough to find it, without
# reading pixels: 37 ms for 1,000 files.
def _check_plates_complete(plan: ExportPlan) -> None:
    """Raise InputError for incomplete plates, before hours are spent on other frames."""
    cut_paths = find_incomplete(file.path for frame in plan.frames for file in frame.origin.files)
    if cut_paths:
        fault = (
            "is empty" if cut_paths[0].stat().st_size == 0 else "is cut off before its last pixels"
        )
        more_names = ", ".join(path.name for path in cut_paths[1:_MOST_NAMED_FILES])
        more_words = f", and so with {len(cut_paths) - 1} more ({more_names})" if more_names else ""
        raise InputError(
            f"{cut_paths[0]} {fault}{more_words}. Write or copy such files again, or export other "
            "frames with "
            "--frames."
        )


def _check_inputs_not_overwritten(plan: ExportPlan) -> None:
    """Raise InputError if an output file is also an input of the export."""
    existing_frames = [frame for frame in plan.frames if os.path.lexists(frame.path)]
    input_paths = (
        {file.path for frame in plan.frames for file in frame.origin.files}
        if existing_frames
        else ()
    )
    input_real_paths = {os.path.realpath(file_on_disk(path)) for path in input_paths}
    for frame in existing_frames:
        if os.path.realpath(frame.path) in input_real_paths:
            raise InputError(
                f"{frame.path} is an input of this export: give another name for the output."
            )


# A frame is rendered again exactly if something that decides its pixels has changed. Time stamps of
# the output files could not tell that. Options of later versions are left out at their default
# values; a new option then does not invalidate frames that it does not change. Folders are left
# out, because they differ between the machines of a farm.
def fingerprint_of(job: ExportJob, frame: int, lens: Lens, origin: Origin) -> str:
    """Return 32 hexadecimal digits that are equal if nothing that decides the pixels differs."""
    stamps = [file.stamp for file in origin.files]
    return digest(
        {
            "version": __version__,
            "frame": frame,
            "plate": stamps[0] if stamps else None,
            **({"beside": stamps[1:]} if stamps[1:] else {}),
            "is_black": origin.is_black,
            "plate_options": _cached_plain_options(job.shot.plate_options),
            "lens": to_json(lens.without_advice()),
            "framing": _cached_plain(job.shot.framing or Framing()),
            "defocus": None if job.pinhole else _cached_plain(job.shot.defocus),
            **({} if job.pinhole else {"blur": BLUR_EDITION}),
            **(
                {"around_and_behind": to_json(job.pinhole_options)}
                if job.pinhole_options != PinholeOptions()
                else {}
            ),
            "output": _output_facts(job),
            **({"timecode": _timecode_start(job)} if job.shot.start_timecode else {}),
        }
    )


# Values that are the same for all frames are converted once. With this and a set of the requested
# frames, a plan of 10,000 frames takes half the time.
_cached_plain = lru_cache(maxsize=8)(to_json)


@lru_cache(maxsize=8)
def _cached_plain_options(options: PlateOptions) -> object:
    """Return the options without folders, which differ between machines: files have stamps."""
    return to_json(options.with_files_beside(os.path.basename))


def _timecode_start(job: ExportJob) -> str:
    """Return the start timecode as text; for a still, with the first exported frame.

    The frames of a still count from the first exported one.
    """
    start = str(job.shot.start_timecode)
    return start if job.shot.span is not None else f"{start} at {min(job.frames)}"


def fingerprint_of_movie(frames: Iterable[str], frames_per_second: float) -> str:
    """Return the fingerprint of a movie from those of its frames."""
    movie_facts = {"frames": list(frames), "frames_per_second": frames_per_second}
    return digest({**movie_facts, "encoding": _MOVIE_ENCODING})


def _output_facts(job: ExportJob) -> dict[str, object]:
    """Return the options that have an effect on this kind of file."""
    options, display_settings = job.options, job.display_settings
    if job.output.is_exr:
        exr_facts = {
            name: getattr(options, name) for name in ("compression", "with_depth", "with_coc")
        }
        exr_facts |= {"keep": to_json(job.keep)} if job.keep else {}
        rate_fact = {"frames_per_second": job.shot.frames_per_second}  # it is in the header
        return {
            "kind": ".exr",
            "half": not options.is_float,
            **rate_fact,
            **exr_facts,
            **_options_added_later(job, EXR),
        }
    return {
        "kind": job.output.suffix,
        "view": [display_settings.transform.key, display_settings.transform.input_space],
        "exposure_stops": display_settings.exposure_stops,
        "gamma": display_settings.gamma,
        "burn_in": [options.burn_in_text, options.unit, options.shot_name]
        if options.burn_in
        else None,
        **(
            {"guides": to_json(display_settings.guides)}
            if display_settings.guides != NO_GUIDES
            else {}
        ),
        **_options_added_later(job, LOOK),
    }


def _options_added_later(job: ExportJob, group: str) -> dict[str, object]:
    """Return the options of a group that are not at their default, without those of version 1.

    Fingerprints of the first version contain only `_FIRST_FIELDS`.
    """
    default_options = ExportOptions()
    names = [name for name in options_of_group(group) if name not in _FIRST_FIELDS]
    chosen = {name: getattr(job.options, name) for name in names}
    return {
        name: to_json(value)
        for name, value in chosen.items()
        if value != getattr(default_options, name)
    }
