"""Export a cut as one movie: the frames of its shots become lossless files, and are joined."""

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import Reel
from heatlens.deliver.export.finished import is_movie_finished
from heatlens.deliver.export.frame_files import RenderedFrame
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.kept_frames import read_kept
from heatlens.deliver.export.movie import movie_file
from heatlens.deliver.export.movie_sound import Spot, heard
from heatlens.deliver.export.output import Output, parse_output
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame, fingerprint_of_movie
from heatlens.deliver.export.run import FrameDone
from heatlens.media.files.atomic_file import check_writable, make_folder


@dataclass(frozen=True)
class Cut:
    """The movie of a reel; `parts` are the plans of its shots, in the files of `kept_movie`."""

    reel: Reel
    output: Output
    parts: tuple[ExportPlan, ...]

    @property
    def gaps(self) -> dict[int, int]:
        """The black frames before shots, by the number of the shot."""
        return dict(self.reel.gaps)

    @property
    def path(self) -> Path:
        """The file of the movie."""
        return self.output.path_at(0)

    @property
    def fingerprint(self) -> str:
        fingerprints = ["black" if it is None else it.fingerprint for it in self.shown]
        return fingerprint_of_movie(fingerprints, self.reel.frames_per_second)

    @property
    def shown(self) -> list[PlannedFrame | None]:
        """What each frame of the movie shows: a frame of a shot, or black as None."""
        frames = list[PlannedFrame | None]()
        for number in range(len(self.parts)):
            frames += [None] * self.gaps.get(number, 0)
            frames += self.shown_of(number)
        return frames + [None] * self.gaps.get(len(self.parts), 0)

    def shown_of(self, number: int) -> Sequence[PlannedFrame]:
        """Return the frames of a shot as the cut plays them, some held and some left out."""
        shot, made = self.reel.shots[number], self.parts[number].frames
        if shot.retime is None:
            return made
        by_number = {frame.frame: frame for frame in made}
        return [by_number[frame] for frame in shot.shown]


def kept_movie(output: Output, number: int, name: str) -> Output:
    """Return the output beside which the frames of a shot are kept until all are joined."""
    movie = output.path_at(0)
    return parse_output(movie.with_name(f"{movie.name}.frames") / f"{number:03}_{name}.mov")


def export_cut(
    cut: Cut, made: Callable[[int], AbstractContextManager[Iterator[FrameDone]]]
) -> Generator[tuple[int, FrameDone]]:
    """Export one frame a step, with the number of its shot from 0 on; then join all frames.

    `made` gives the frames of a shot as they are finished. Raises InputError as `export_frames`
    does, and if the shots have different sizes.
    """
    force = any(plan.job.options.force for plan in cut.parts)
    if not force and is_movie_finished(cut.path, cut.fingerprint):
        for at, plan in enumerate(cut.parts):
            yield from ((at, FrameDone(it.frame, it.path, True)) for it in plan.frames)
        return
    make_folder(cut.output.folder)
    check_writable(cut.path)
    for at in range(len(cut.parts)):
        with made(at) as steps:
            yield from ((at, done) for done in steps)
    _join(cut)
    _remove(cut)


def _join(cut: Cut) -> None:
    black = _black_like(cut.parts[0])
    with movie_file(_job_of(cut), cut.path, cut.fingerprint, _spots(cut)) as movie:
        for frame in cut.shown:
            kept = black if frame is None else read_kept(frame.path, frame)
            movie.write(replace(kept, planned=black.planned))


def _spots(cut: Cut) -> list[Spot | None]:
    """Return whose sound each frame of the movie has; None for silence."""
    spots = list[Spot | None]()
    for number, plan in enumerate(cut.parts):
        spots += [None] * cut.gaps.get(number, 0)
        spots += heard_in_cut(cut, plan, number)[0]
    return spots + [None] * cut.gaps.get(len(cut.parts), 0)


def heard_in_cut(cut: Cut, plan: ExportPlan, number: int) -> tuple[tuple[Spot | None, ...], str]:
    """Return whose sound the frames of a shot have, and a sentence if it is left out.

    What is played at another speed has none, because its frames are held or left out.
    """
    spots, left_out = heard(plan, cut.reel.frames_per_second)
    if cut.reel.shots[number].retime is None:
        return spots, left_out
    has_sound = any(spot is not None for spot in spots)
    silent = (None,) * len(cut.shown_of(number))
    name = cut.reel.shots[number].name
    why = f"The sound of {name} is left out, because the cut changes its speed."
    return silent, why if has_sound else left_out


def _black_like(plan: ExportPlan) -> RenderedFrame:
    """Return a black picture of the size of the first frame, as the first frame of the cut."""
    first = plan.frames[0]
    read = read_kept(first.path, first)
    return replace(read, planned=replace(first, frame=1), pixels=np.zeros_like(read.pixels))


def _job_of(cut: Cut) -> ExportJob:
    """Return the job of the whole movie, whose frames count from 1."""
    first = cut.parts[0].job
    count = len(cut.shown)
    shot = replace(
        first.shot,
        frames=FrameRange(1, count),
        in_out=None,
        frames_per_second=cut.reel.frames_per_second,
        start_timecode=cut.reel.start_timecode,
    )
    return replace(first, shot=shot, frames=tuple(range(1, count + 1)), output=cut.output)


def _remove(cut: Cut) -> None:
    """Delete the files of the frames, which the movie has replaced."""
    folders = dict.fromkeys(plan.folder for plan in cut.parts)
    with suppress(OSError):  # those that stay do no harm
        for plan in cut.parts:
            for frame in plan.frames:
                frame.path.unlink(missing_ok=True)
        for folder in folders:
            folder.rmdir()
        cut.parts[0].job.output.folder.rmdir()
