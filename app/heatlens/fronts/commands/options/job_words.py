"""Write the words of the command that each task of a farm job runs."""

import argparse
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.deliver.export.plan import ExportPlan
from heatlens.deliver.farm.inputs import absolute_path, aperture_images
from heatlens.deliver.farm.job import Place, Word, path_word
from heatlens.fronts.commands.export_options import add_export_options
from heatlens.fronts.commands.options.given_options import changed_options
from heatlens.media.documents.reel_file import REEL_SUFFIX
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.sequence.names import frames_text

# Options that are set for each task, or are useless there.
_TASK_OPTIONS = (
    *("--frames", "--plate", "--ocio", "--progress", "--submit", "--bundle", "--moved"),
    *("--chunk", "--memory", "--cpus", "--gpus", "--part", "--cluster", "--fetch"),
    *("--processes", "--device", "--expect"),
)
_FILE_OPTIONS = ("--depth", "--behind", "--aperture-image")  # options that name files


@dataclass(frozen=True)
class JobWords:
    """Makes the command lines of one job.

    config    the OpenColorIO config of pictures and movies
    expected  version and driver that the job was written with, see `--expect`
    """

    places: tuple[Place, ...]
    config: str | None
    expected: str | None

    def shot_command(self, args: argparse.Namespace, plan: ExportPlan) -> Iterator[Word]:
        """Yield the words of the export of a shot."""
        job = plan.job
        source, output = plan.source.files, absolute_path(job.output.pattern)
        # A source without files is the built-in scene, which exists on every machine.
        name, has_file = str(job.shot.source), is_shot_file(args.shot)
        plate_prefix = "--plate=" if has_file else ""
        yield ("export",)
        if has_file:
            yield self._path_word("", args.shot)
        yield (plate_prefix + name,) if source is None else self._path_word(plate_prefix, source)
        yield self._path_word("--output=", output, "OUT")
        if has_file and (job.shot.plate_options.files_beside or aperture_images(job.shot)):
            yield from self._moved_options(absolute_path(args.shot).parent)
        yield from self._given_options(args)
        yield (f"--frames={frames_text(job.frames)}",)

    def reel_command(self, args: argparse.Namespace) -> Iterator[Word]:
        """Yield the words of the export of a whole reel."""
        yield from (
            ("export",),
            self._path_word("", args.shot),
            self._path_word("--output=", args.output, "OUT"),
        )
        yield from (self._path_word("--media=", folder) for folder in args.media)
        if not args.shot.lower().endswith(REEL_SUFFIX):  # an edit, which may name absolute paths
            yield from (("--media=", folder) for folder in self._input_folders)
        if args.edit_out is not None:
            yield self._path_word("--edit-out=", args.edit_out, "OUT")
        numbers = {"--edit-fps": args.edit_fps, "--handles": args.handles}
        yield from ((f"{option}={value:g}",) for option, value in numbers.items() if value)
        yield from self._given_options(args)

    def _path_word(self, prefix: str, path: str | os.PathLike[str], flow: str = "IN") -> Word:
        """Return a word that joins `prefix` and a path.

        The path is relative to a place of the same flow, because an output may lie in an input
        folder.
        """
        return path_word([it for it in self.places if it.flow == flow], prefix, absolute_path(path))

    @property
    def _input_folders(self) -> list[Place]:
        """The folders that the job reads."""
        return [it for it in self.places if it.kind == "DIRECTORY" and it.flow == "IN"]

    def _moved_options(self, folder: Path) -> Iterator[Word]:
        """Yield --moved for each folder that a shot in `folder` names, relative and absolute."""
        for place in self._input_folders:
            for old_folder in (os.path.relpath(place.path, folder), str(place.path)):
                yield from (("--moved",), (old_folder,), (place,))

    def _given_options(self, args: argparse.Namespace) -> Iterator[Word]:
        """Yield the given options as they would be typed, and the config and program of the job."""
        for option, values in changed_options(args, add_export_options).items():
            for value in values if isinstance(values, list) else [values]:  # given several times
                if option in _FILE_OPTIONS:
                    name = value.path if isinstance(value, OpeningImage) else str(value)
                    yield self._path_word(f"{option}=", name)
                elif option not in _TASK_OPTIONS:
                    yield (option,) if value is True else (f"{option}={_value_text(value)}",)
        if self.config is not None:
            has_file = Path(self.config).is_file()
            yield (
                self._path_word("--ocio=", self.config) if has_file else (f"--ocio={self.config}",)
            )
        if self.expected is not None:
            yield (f"--expect={self.expected}",)


def _value_text(value: object) -> str:
    """Return a value of an option as it was typed: 320x180 for a size."""
    return "x".join(map(str, value)) if isinstance(value, tuple) else str(value)
