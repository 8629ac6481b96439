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
from heatlens.deliver.export.kept_frames import read_kept_frame
from heatlens.deliver.export.movie import movie_file
from heatlens.deliver.export.movie_sound import SoundFrame, find_sound
from heatlens.deliver.export.output import Output, parse_output
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame, fingerprint_of_movie
from heatlens.deliver.export.run import FrameDone
from heatlens.media.files.atomic_file import check_writable, make_folder


@dataclass(frozen=True)
class Cut:
    """The movie of a reel.

    `parts` are the plans of its shots; each writes its frames beside `kept_frames_output`.
    """

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
        """The fingerprint of the movie: that of all its frames in order."""
        fingerprints = [
            "black" if frame is None else frame.fingerprint for frame in self.movie_frames
        ]
        return fingerprint_of_movie(fingerprints, self.reel.frames_per_second)

    @property
    def movie_frames(self) -> list[PlannedFrame | None]:
        """The frame of a shot that each frame of the movie shows; None for a black frame."""
        frames = list[PlannedFrame | None]()
        for number in range(len(self.parts)):
            frames += [None] * self.gaps.get(number, 0)
            frames += self.frames_of_shot(number)
        return frames + [None] * self.gaps.get(len(self.parts), 0)

    def frames_of_shot(self, shot_number: int) -> Sequence[PlannedFrame]:
        """Return the frames of a shot in the order in which the cut plays them.

        A retime repeats some of them and leaves others out.
        """
        shot, rendered_frames = self.reel.shots[shot_number], self.parts[shot_number].frames
        if shot.retime is None:
            return rendered_frames
        by_number = {frame.frame: frame for frame in rendered_frames}
        return [by_number[frame] for frame in shot.source_frames]


def kept_frames_output(output: Output, number: int, name: str) -> Output:
    """Return the output of one shot of a cut, in a folder beside the movie.

    The frames of the shot are kept there until those of all shots are joined.
    """
    movie = output.path_at(0)
    return parse_output(movie.with_name(f"{movie.name}.frames") / f"{number:03}_{name}.mov")


def export_cut(
    cut: Cut, export_shot: Callable[[int], AbstractContextManager[Iterator[FrameDone]]]
) -> Generator[tuple[int, FrameDone]]:
    """Export one frame a step, with the number of its shot from 0 on; then join all frames.

    `export_shot` opens the export of the shot of a number, which yields the frames of that shot as
    they are finished. Raises InputError as `export_frames` does, and if the shots have different
    sizes.
    """
    force = any(plan.job.options.force for plan in cut.parts)
    if not force and is_movie_finished(cut.path, cut.fingerprint):
        for shot_number, plan in enumerate(cut.parts):
            yield from (
                (shot_number, FrameDone(frame.frame, frame.path, was_there=True))
                for frame in plan.frames
            )
        return
    make_folder(cut.output.folder)
    check_writable(cut.path)
    for shot_number in range(len(cut.parts)):
        with export_shot(shot_number) as steps:
            yield from ((shot_number, done) for done in steps)
    _join_frames(cut)
    _delete_kept_frames(cut)


def _join_frames(cut: Cut) -> None:
    """Write the kept frames of all shots, and the black frames between them, into the movie."""
    black_frame = _black_frame_like(cut.parts[0])
    with movie_file(_whole_movie_job(cut), cut.path, cut.fingerprint, _sound_frames(cut)) as movie:
        for frame in cut.movie_frames:
            rendered = black_frame if frame is None else read_kept_frame(frame.path, frame)
            movie.write(replace(rendered, planned=black_frame.planned))


def _sound_frames(cut: Cut) -> list[SoundFrame | None]:
    """Return the source of the sound of each frame of the movie; None for silence."""
    sound_frames = list[SoundFrame | None]()
    for number, plan in enumerate(cut.parts):
        sound_frames += [None] * cut.gaps.get(number, 0)
        sound_frames += find_sound_in_cut(cut, plan, number)[0]
    return sound_frames + [None] * cut.gaps.get(len(cut.parts), 0)


def find_sound_in_cut(
    cut: Cut, plan: ExportPlan, shot_number: int
) -> tuple[tuple[SoundFrame | None, ...], str]:
    """Return the source of the sound of each frame of a shot, and a message if it is left out.

    A retimed shot has no sound, because its frames are repeated or left out.
    """
    sound_frames, message = find_sound(plan, cut.reel.frames_per_second)
    if cut.reel.shots[shot_number].retime is None:
        return sound_frames, message
    has_sound = any(spot is not None for spot in sound_frames)
    silence = (None,) * len(cut.frames_of_shot(shot_number))
    name = cut.reel.shots[shot_number].name
    cut_message = f"The sound of {name} is left out, because the cut changes its speed."
    return silence, cut_message if has_sound else message


def _black_frame_like(plan: ExportPlan) -> RenderedFrame:
    """Return a black picture of the size of the first frame, as the first frame of the cut."""
    first = plan.frames[0]
    first_frame = read_kept_frame(first.path, first)
    return replace(
        first_frame, planned=replace(first, frame=1), pixels=np.zeros_like(first_frame.pixels)
    )


def _whole_movie_job(cut: Cut) -> ExportJob:
    """Return the job of the whole movie, whose frames count from 1."""
    first = cut.parts[0].job
    count = len(cut.movie_frames)
    shot = replace(
        first.shot,
        frames=FrameRange(1, count),
        in_out=None,
        frames_per_second=cut.reel.frames_per_second,
        start_timecode=cut.reel.start_timecode,
    )
    return replace(first, shot=shot, frames=tuple(range(1, count + 1)), output=cut.output)


def _delete_kept_frames(cut: Cut) -> None:
    """Delete the files of the frames, which the movie has replaced."""
    folders = dict.fromkeys(plan.folder for plan in cut.parts)
    with suppress(OSError):  # those that stay do no harm
        for plan in cut.parts:
            for frame in plan.frames:
                frame.path.unlink(missing_ok=True)
        for folder in folders:
            folder.rmdir()
        cut.parts[0].job.output.folder.rmdir()
