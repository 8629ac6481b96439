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
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import NO_GUIDES
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.options import EXR, LOOK, ExportOptions, of_group
from heatlens.deliver.export.output import check_names
from heatlens.deliver.export.pinhole_plate import PinholeOptions
from heatlens.media.files.json_record import digest, plain
from heatlens.media.files.picture_formats import file_on_disk
from heatlens.media.plate.exr.exr_whole import cut_short
from heatlens.media.sequence.names import parse_frames
from heatlens.render.source.named import source_of
from heatlens.render.source.source import Origin, Source
from heatlens.version import __version__

_NAMED_MOST = 5  # most files named in a sentence
# Increased when the same frames give another movie: 1 had wrong pixels, 2 was 0.4 % too bright.
_MOVIE_ENCODING = 3

_FIRST_FIELDS = {"is_float", "compression", "with_depth", "with_coc", "keep_channels"} | {
    *("burn_in", "unit", "burn_in_text", "shot_name"),
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

    is_part  only some of the frames are made here, those of a movie as files of their own
    """

    job: ExportJob
    source: Source
    frames: tuple[PlannedFrame, ...]
    is_part: bool = False

    @property
    def makes_movie(self) -> bool:
        """Return True if all frames go into one file."""
        return self.job.output.is_movie and not self.is_part

    @property
    def folder(self) -> Path:
        """Return the folder that the files are written to."""
        return self.frames[0].path.parent

    @property
    def movie_fingerprint(self) -> str:
        """Return the fingerprint of a movie of all frames."""
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


def planned(job: ExportJob, part: Sequence[int] | None = None) -> ExportPlan:
    """Return the plan of a job. Input files are looked up, but nothing is written.

    With `part`, only these of its frames are planned, and those of a movie as `kept_path`. Raises
    InputError if a scene is missing, if a plate is missing and the job does not allow to replace
    it, if an output would overwrite an input, or if the lens is impossible.
    """
    source, frames = source_of(job.shot), job.frames if part is None else part
    source.check(job.shot, tuple(frames), job.options.missing)
    is_part = part is not None
    check_names(job.output, job.frames, has_folder=not is_part)
    made = tuple(_planned(job, source, frame, is_part) for frame in frames)
    plan = ExportPlan(job, source, made, is_part)
    _check_sources_stay(plan)
    _check_whole(plan)
    return plan


def _planned(job: ExportJob, source: Source, frame: int, is_part: bool) -> PlannedFrame:
    lens = job.shot.lens_at(frame)
    origin = source.origin(job.shot, frame, job.options.missing)
    mark = fingerprint_of(job, frame, lens, origin)
    path = job.output.path_at(frame)
    path = kept_path(path, frame) if is_part and job.output.is_movie else path
    return PlannedFrame(frame, origin, lens, path, mark)


# A file that was cut short has a valid header and was found only when its turn came. Headers,
# tables of chunks and lengths tell it without the pixels: 37 ms for 1,000 files.
def _check_whole(plan: ExportPlan) -> None:
    """Raise InputError for incomplete plates, before hours are spent on others."""
    short = cut_short(file.path for frame in plan.frames for file in frame.origin.files)
    if short:
        what = "is empty" if short[0].stat().st_size == 0 else "is cut off before its last pixels"
        others = ", ".join(path.name for path in short[1:_NAMED_MOST])
        more = f", and so with {len(short) - 1} more ({others})" if others else ""
        raise InputError(
            f"{short[0]} {what}{more}. Write or copy such files again, or export other frames with "
            "--frames."
        )


def _check_sources_stay(plan: ExportPlan) -> None:
    there = [frame for frame in plan.frames if os.path.lexists(frame.path)]
    paths = {file.path for frame in plan.frames for file in frame.origin.files} if there else ()
    read = {os.path.realpath(file_on_disk(path)) for path in paths}
    for frame in there:
        if os.path.realpath(frame.path) in read:
            raise InputError(
                f"{frame.path} is an input of this export: give another name for the output."
            )


# Time stamps of files would not do: a frame is made again exactly if something that decides its
# pixels has changed, and it is left if nothing has, whoever made it. Entries that were added later
# are left out at their usual values, so that a new option makes nothing again that it does not
# change. Folders are left out, because they differ between the machines of a farm.
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
            "plate_options": _plain_options(job.shot.plate_options),
            "lens": plain(lens.without_advice()),
            "framing": _plain_of_all(job.shot.framing or Framing()),
            "defocus": None if job.pinhole else _plain_of_all(job.shot.defocus),
            **({"around_and_behind": plain(job.beside)} if job.beside != PinholeOptions() else {}),
            "output": _output_facts(job),
            **({"timecode": _start_of(job)} if job.shot.start_timecode else {}),
        }
    )


# What is the same for all frames is converted once. With this and a set of the wanted frames, a
# plan of 10,000 frames takes half the time.
_plain_of_all = lru_cache(maxsize=8)(plain)  # for values that are the same for all frames


@lru_cache(maxsize=8)
def _plain_options(options: PlateOptions) -> object:
    """Return the options without folders, which differ between machines: files have stamps."""
    return plain(options.with_files_beside(os.path.basename))


def _start_of(job: ExportJob) -> str:
    """Return the start of the timecode; frames of a still count from the first exported one."""
    start = str(job.shot.start_timecode)
    return start if job.shot.span is not None else f"{start} at {min(job.frames)}"


def fingerprint_of_movie(frames: Iterable[str], frames_per_second: float) -> str:
    """Return the fingerprint of a movie from those of its frames."""
    of_movie = {"frames": list(frames), "frames_per_second": frames_per_second}
    return digest({**of_movie, "encoding": _MOVIE_ENCODING})


def _output_facts(job: ExportJob) -> dict[str, object]:
    """Return the options that have an effect on this kind of file."""
    options, look = job.options, job.look
    if job.output.is_exr:
        own = {name: getattr(options, name) for name in ("compression", "with_depth", "with_coc")}
        own |= {"keep": plain(job.keep)} if job.keep else {}
        rate = {"frames_per_second": job.shot.frames_per_second}  # it is in the header
        return {"kind": ".exr", "half": not options.is_float, **rate, **own, **_newer(job, EXR)}
    return {
        "kind": job.output.suffix,
        "view": [look.transform.key, look.transform.input_space],
        "exposure_stops": look.exposure_stops,
        "gamma": look.gamma,
        "burn_in": _burned_in(options) if options.burn_in else None,
        **({"guides": plain(look.guides)} if look.guides != NO_GUIDES else {}),
        **_newer(job, LOOK),
    }


def _burned_in(options: ExportOptions) -> list[str]:
    return [options.burn_in_text, options.unit, options.shot_name]


def _newer(job: ExportJob, group: str) -> dict[str, object]:
    """Return the chosen options of a group that files of earlier versions do not contain."""
    usual, names = ExportOptions(), [name for name in of_group(group) if name not in _FIRST_FIELDS]
    chosen = {name: getattr(job.options, name) for name in names}
    return {name: plain(value) for name, value in chosen.items() if value != getattr(usual, name)}
