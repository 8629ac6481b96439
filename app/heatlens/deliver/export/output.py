"""The output files of an export: numbered pictures, or one movie."""

import os
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.media.files.atomic_file import check_folder
from heatlens.media.files.picture_formats import suffixes_written, writing_of
from heatlens.media.sequence.names import NameForm, parse_pattern

MOVIE_SUFFIXES = (".mov", ".mp4")


@dataclass(frozen=True)
class Output:
    """The files of an export; a name without a number is a single file."""

    folder: Path
    form: NameForm

    @property
    def suffix(self) -> str:
        """The file extension: .exr, one of another picture, or one of MOVIE_SUFFIXES."""
        return Path(self.form.name_at(0)).suffix.lower()

    @property
    def is_exr(self) -> bool:
        """True for EXR, which is scene-linear; all others are display pictures."""
        return self.suffix == ".exr"

    @property
    def is_movie(self) -> bool:
        """True if all frames are in one file."""
        return self.suffix in MOVIE_SUFFIXES

    @property
    def pattern(self) -> Path:
        """The name with #### for the frame number: out/name.####.exr."""
        return self.folder / self.form.text

    def path_at(self, frame: int) -> Path:
        """Return the file of `frame`."""
        return self.folder / self.form.name_at(frame)


def parse_output(text: str | os.PathLike[str]) -> Output:
    """Parse an output such as out/name.####.exr, in any notation for the frame number.

    Raises InputError for an unsupported kind of file, and for a movie with a number.
    """
    path = Path(os.path.expanduser(text))
    parsed_name = parse_pattern(path.name)
    form, frames = parsed_name or (NameForm(prefix=path.name, padding=0, suffix=""), None)
    output = Output(path.parent, form)
    suffixes = (*suffixes_written(), *MOVIE_SUFFIXES)
    if output.suffix not in suffixes or path.is_dir():
        raise InputError(f"{path}: the output must end in {', '.join(suffixes)}.")
    if not (output.is_exr or output.is_movie):
        writing_of(path).require()
    if frames is not None:
        raise InputError(f"{path} names frames. Give them with --frames, and write #### here.")
    if output.is_movie and parsed_name is not None:
        raise InputError(f"{path}: a movie is one file. Leave #### out of its name.")
    return output


def check_names(output: Output, frames: tuple[int, ...], has_folder: bool = True) -> None:
    """Raise InputError if several frames have the same name, or their folder cannot be made.

    If `has_folder` is False the folder is not checked, because it will be made when it is needed.
    """
    if len(frames) > 1 and not (output.is_movie or output.form.padding):
        name = Path(output.form.text)
        raise InputError(
            f"{output.pattern} is a single name for {len(frames)} frames. Write it as "
            f"{name.stem}.####{name.suffix}."
        )
    if has_folder:
        check_folder(output.pattern)
