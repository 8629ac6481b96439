"""The command lines of the tasks of a job, with places in the place of paths."""

import argparse
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from heatlens.commands.export_options import add_export_options
from heatlens.commands.options.given_options import given
from heatlens.documents.reel_file import REEL_SUFFIX
from heatlens.documents.shot_file import is_shot_file
from heatlens.export.plan import ExportPlan
from heatlens.farm.inputs import images_of, plain_path
from heatlens.farm.job import Place, Word, located
from heatlens.model.lens.opening_image import OpeningImage
from heatlens.sequence.names import frames_text

# Options that are set for each task, or are useless there.
_REPLACED = (
    *("--frames", "--plate", "--ocio", "--progress", "--submit", "--bundle", "--moved"),
    *("--chunk", "--memory", "--cpus", "--gpus", "--part", "--cluster", "--fetch"),
    *("--processes", "--device", "--expect"),
)
_FILES = ("--depth", "--behind", "--aperture-image")  # options that name files


@dataclass(frozen=True)
class JobWords:
    """Makes the command lines of one job.

    config    the OpenColorIO config of pictures and movies
    expected  version and driver that the job was written with, see `--expect`
    """

    places: tuple[Place, ...]
    config: str | None
    expected: str | None

    def of_shot(self, args: argparse.Namespace, plan: ExportPlan) -> Iterator[Word]:
        """Yield the words of the export of a shot."""
        job = plan.job
        source, output = plan.source.files, plain_path(job.output.pattern)
        # A source without files is the built-in scene, which exists on every machine.
        name, has_file = str(job.shot.source), is_shot_file(args.shot)
        lead = "--plate=" if has_file else ""
        yield ("export",)
        if has_file:
            yield self._at("", args.shot)
        yield (lead + name,) if source is None else self._at(lead, source)
        yield self._at("--output=", output, "OUT")
        if has_file and (job.shot.plate_options.files_beside or images_of(job.shot)):
            yield from self._moved(plain_path(args.shot).parent)
        yield from self._given(args)
        yield (f"--frames={frames_text(job.frames)}",)

    def of_reel(self, args: argparse.Namespace) -> Iterator[Word]:
        """Yield the words of the export of a whole reel."""
        yield from (("export",), self._at("", args.shot), self._at("--output=", args.output, "OUT"))
        yield from (self._at("--media=", folder) for folder in args.media)
        if not args.shot.lower().endswith(REEL_SUFFIX):  # an edit, which may name absolute paths
            yield from (("--media=", folder) for folder in self._folders)
        if args.edit_out is not None:
            yield self._at("--edit-out=", args.edit_out, "OUT")
        told = {"--edit-fps": args.edit_fps, "--handles": args.handles}
        yield from ((f"{option}={value:g}",) for option, value in told.items() if value)
        yield from self._given(args)

    def _at(self, lead: str, path: str | os.PathLike[str], flow: str = "IN") -> Word:
        """Return a word that ends with a path; what is written may lie in a folder that is read."""
        return located([it for it in self.places if it.flow == flow], lead, plain_path(path))

    @property
    def _folders(self) -> list[Place]:
        return [it for it in self.places if it.kind == "DIRECTORY" and it.flow == "IN"]

    def _moved(self, folder: Path) -> Iterator[Word]:
        """Yield --moved for each folder that a shot in `folder` names, relative and absolute."""
        for place in self._folders:
            for old in (os.path.relpath(place.path, folder), str(place.path)):
                yield from (("--moved",), (old,), (place,))

    def _given(self, args: argparse.Namespace) -> Iterator[Word]:
        """Yield the given options as they would be typed, and what is the same for all tasks."""
        for option, values in given(args, add_export_options).items():
            for value in values if isinstance(values, list) else [values]:  # given several times
                if option in _FILES:
                    name = value.path if isinstance(value, OpeningImage) else str(value)
                    yield self._at(f"{option}=", name)
                elif option not in _REPLACED:
                    yield (option,) if value is True else (f"{option}={_typed(value)}",)
        if self.config is not None:
            has_file = Path(self.config).is_file()
            yield self._at("--ocio=", self.config) if has_file else (f"--ocio={self.config}",)
        if self.expected is not None:
            yield (f"--expect={self.expected}",)


def _typed(value: object) -> str:
    """Return a value of an option as it was typed: 320x180 for a size."""
    return "x".join(map(str, value)) if isinstance(value, tuple) else str(value)
