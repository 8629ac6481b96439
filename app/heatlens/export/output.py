"""Where an export goes: numbered pictures, or one movie."""

import os
from dataclasses import dataclass
from pathlib import Path

from heatlens.errors import InputError
from heatlens.files.output_check import check_writable
from heatlens.plate.png_write import EYE_SUFFIXES
from heatlens.sequence.names import NameForm, parse_pattern
from heatlens.stopping import folder_made

MOVIE_SUFFIXES = (".mov", ".mp4")
_SUFFIXES = (".exr", *EYE_SUFFIXES, *MOVIE_SUFFIXES)


@dataclass(frozen=True)
class Output:
    """The files of an export; without a number in its name it is one file."""

    folder: Path
    form: NameForm

    @property
    def suffix(self) -> str:
        """The kind of file: .exr, one of EYE_SUFFIXES or of MOVIE_SUFFIXES."""
        return Path(self.form.name_at(0)).suffix.lower()

    @property
    def is_exr(self) -> bool:
        """Scene-linear; all others are pictures for the eye."""
        return self.suffix == ".exr"

    @property
    def is_movie(self) -> bool:
        """All frames in one file."""
        return self.suffix in MOVIE_SUFFIXES

    @property
    def pattern(self) -> Path:
        """The name for people: out/name.####.exr."""
        return self.folder / self.form.text

    def path_at(self, frame: int) -> Path:
        """Return the file of `frame`."""
        return self.folder / self.form.name_at(frame)


def parse_output(text: str | os.PathLike[str]) -> Output:
    """Return the files that out/name.####.exr means, in any notation for the frame number.

    Raises InputError for a kind of file that is not written, and for a movie with a number.
    """
    path = Path(text).expanduser()
    parsed = parse_pattern(path.name)
    form, frames = parsed or (NameForm(path.name, 0, ""), None)
    output = Output(path.parent, form)
    if output.suffix not in _SUFFIXES or path.is_dir():
        raise InputError(f"{path}: the output must end in {', '.join(_SUFFIXES)}.")
    if frames is not None:
        raise InputError(f"{path} names frames. Give them with --frames, and write #### here.")
    if output.is_movie and parsed is not None:
        raise InputError(f"{path}: a movie is one file. Leave #### out of its name.")
    return output


def check_names(output: Output, frames: tuple[int, ...]) -> None:
    """Raise InputError where several frames have one name, or their folder cannot be made."""
    if len(frames) > 1 and not (output.is_movie or output.form.padding):
        name = Path(output.form.text)
        raise InputError(
            f"{output.pattern} is a single name for {len(frames)} frames. Write it as "
            f"{name.stem}.####{name.suffix}."
        )
    if not output.folder.is_dir() and not output.folder.parent.is_dir():
        raise InputError(f"{output.pattern}: there is no folder {output.folder.parent}.")


def make_folder(output: Output) -> None:
    """Make the folder of the files, inside one that exists. Raises InputError."""
    try:
        if not output.folder.is_dir():
            folder_made(output.folder)
        output.folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(
            f"The folder {output.folder} cannot be made: {error.strerror or error}."
        ) from error
    check_writable(output.path_at(0))
