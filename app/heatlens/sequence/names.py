"""File names of a sequence: what is the frame number in them, and what stands around it.

Notations are parsed by fileseq, one name at a time, so that a folder may be called anything.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from fileseq.constants import PAD_STYLE_HASH1
from fileseq.filesequence import FileSequence
from fileseq.frameset import FrameSet

from heatlens.errors import InputError

_LEAST_PART = 0.1  # of the frames from first to last, where the name leaves a doubt
MAX_FRAMES = 1_000_000  # twelve hours; more is a date or a hash read as a frame number

# The first number that only words, versions and the extension follow: sh010.comp1001.left.v2.exr.
_NUMBERED = re.compile(
    r"(.*?)(-?[0-9]+)((?:\.[^.]*[A-Za-z]|\.[vV][0-9]+)*\.[^.]*[A-Za-z][^.]*)", re.ASCII | re.DOTALL
)
_NUMBER = re.compile(r"-?[0-9]+", re.ASCII)
_VERSION = re.compile(r".*(^|[^A-Za-z])[vV]", re.DOTALL)  # what comes before the 02 of shot_v02.exr


@dataclass(frozen=True)
class NameForm:
    """`prefix`, the frame number in `padding` digits or more, `suffix`; padding 0 is no number."""

    prefix: str
    padding: int
    suffix: str

    def name_at(self, frame: int) -> str:
        """Return the file name of `frame`; a sign counts as one of the digits, as in %04d."""
        number = str(frame).zfill(self.padding) if self.padding else ""
        return f"{self.prefix}{number}{self.suffix}"

    def number_in(self, name: str) -> str | None:
        """Return the digits of `name`, whatever their padding; None where it is of another form."""
        if not (name.startswith(self.prefix) and name.endswith(self.suffix)):
            return None
        digits = name[len(self.prefix) : len(name) - len(self.suffix)]
        if not _NUMBER.fullmatch(digits) or (digits[0] == "-" and not _takes_sign(self.prefix)):
            return None
        return digits

    def frames_in(self, names: Iterable[str]) -> tuple[int, ...]:
        """Return the frames, sorted, that `names` hold in this form with exactly this padding."""
        numbers = (self.number_in(name) for name in names)
        frames = ((int(number), number) for number in numbers if number is not None)
        return tuple(sorted(f for f, text in frames if str(f).zfill(self.padding) == text))

    @property
    def text(self) -> str:
        """The name with # for each digit."""
        return f"{self.prefix}{'#' * self.padding}{self.suffix}"

    @property
    def is_notation(self) -> bool:
        """True where `text` reads as this form: the name itself holds no marks of a notation."""
        return parse_pattern(self.text) == (self, None)


def form_of(name: str) -> tuple[NameForm, int | None]:
    """Return the form of `name`, with the padding of its number, and the number.

    A version (`shot_v02.exr`) is no frame, and a minus after a letter or digit is a hyphen.
    """
    match = _NUMBERED.fullmatch(name)
    if not match or _VERSION.fullmatch(match[1]):
        return NameForm(name, 0, ""), None
    prefix, digits, suffix = match.groups()
    if digits[0] == "-" and not _takes_sign(prefix):
        prefix, digits = f"{prefix}-", digits[1:]
    return NameForm(prefix, len(digits), suffix), int(digits)


def parse_pattern(name: str) -> tuple[NameForm, str | None] | None:
    """Parse a notation such as `shot.1001-1100x2####.exr`: the form, and its frames, if any.

    A lone number after a letter belongs to the name, so that `take2####.exr` is take 2. Returns
    None for what is no notation.
    """
    try:
        # The default style takes one # for four digits.
        parsed = FileSequence(name, pad_style=PAD_STYLE_HASH1)
    except ValueError:
        return None
    tail = parsed.padding() + parsed.extension()
    if not parsed.padding() or not name.endswith(tail) or _is_foreign(parsed.padding()):
        return None
    head, prefix = name.removesuffix(tail), parsed.basename()
    frames = head.removeprefix(prefix)
    if frames.startswith("-") and not _takes_sign(prefix):
        prefix, frames = f"{prefix}-", frames[1:]
    if frames.isdecimal() and prefix[-1:].isalpha():
        prefix, frames = head, ""
    return NameForm(prefix, parsed.zfill(), parsed.extension()), frames or None


def parse_frames(text: str) -> tuple[int, ...]:
    """Parse `1001-1100x2` or `1001,1005,1010-1020` to sorted frames. Raises InputError."""
    try:
        if re.search(r"\d\s+\d", text):
            raise ValueError("fileseq would join the two numbers")
        read = tuple(FrameSet(text))
    except ValueError as error:  # what fileseq raises derives from it
        raise InputError(_no_frames(text)) from error
    frames = tuple(sorted(frame for frame in read if isinstance(frame, int)))
    if not frames or len(frames) < len(read):
        raise InputError(_no_frames(text))
    if len(frames) > MAX_FRAMES:
        raise InputError(f"Frames {text!r} are {len(frames)}: heatlens takes up to {MAX_FRAMES}.")
    return frames


def frames_text(frames: Iterable[int]) -> str:
    """Format `frames` as ranges, 1001-1100x2,1200, as `parse_frames` reads them."""
    return str(FrameSet.framesToFrameRange(frames, sort=True))


def padding_of(form: NameForm, names: Iterable[str]) -> tuple[int, ...]:
    """Return the paddings that the numbers of `names` have in `form`, usually one.

    Numbers with leading zeros decide; without any, the shortest number does.
    """
    numbers = {number for name in names if (number := form.number_in(name)) is not None}
    padded = {len(number) for number in numbers if number.lstrip("-")[0] == "0" and number != "0"}
    shortest = min(map(len, numbers), default=0)
    return tuple(sorted(padded)) or ((shortest,) if shortest else ())


def are_frames(form: NameForm, frames: Sequence[int]) -> bool:
    """Return whether sorted numbers of `form` count frames, and not sizes or versions.

    A separator before the number (shot.1001.exr) or leading zeros say so. Right after a letter, as
    in hero720.exr and hero1080.exr, a tenth of the frames from first to last must be there.
    """
    if not form.padding or len(frames) < 2:
        return False
    is_padded = any(len(str(abs(frame))) < form.padding for frame in frames)
    if is_padded or not form.prefix[-1:].isalpha():
        return True
    return len(frames) >= _LEAST_PART * (frames[-1] - frames[0] + 1)


def sequences_among(names: Iterable[str]) -> dict[NameForm, tuple[int, ...]]:
    """Return every form among `names` with its frames; none for a picture without a number.

    Hidden files are left out: systems and programs put their own beside ours.
    """
    groups: dict[NameForm, list[str]] = {}
    for name in names:
        if name.startswith("."):
            continue
        form, number = form_of(name)
        groups.setdefault(replace(form, padding=0 if number is None else 1), []).append(name)
    found = {}
    for form, members in groups.items():
        for padding in padding_of(form, members) or (0,):
            padded = replace(form, padding=padding)
            found[padded] = padded.frames_in(members)
    return found


def _takes_sign(prefix: str) -> bool:
    """Return whether a minus after `prefix` can be the sign of a number."""
    return not prefix[-1:].isalnum()


def _is_foreign(padding: str) -> bool:
    """Return True for notations of fileseq that number no whole frames: tiles, sub-frames."""
    return "UDIM" in padding or "." in padding


def _no_frames(text: str) -> str:
    return f"Frames {text!r} cannot be read: write 1001-1100, 1001-1100x2 or 1001,1005,1010-1020."
