"""Parse file names of a sequence into a frame number and the text around it.

Notations are parsed by fileseq one name at a time, without folders, which may have any name.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from heatlens.core.base.errors import InputError

# Share of the frames from first to last that must exist if the name alone does not decide.
_DENSITY_LEAST = 0.1
_DIGITS_MOST = 20  # of a frame number; an absurd padding, as in %4000000000d, would fill the memory
MAX_FRAMES = 1_000_000  # about twelve hours; more comes from a date or a hash in the name

# The first number followed only by words, versions and the extension: sh010.comp1001.left.v2.exr.
_NUMBERED = re.compile(
    r"(.*?)(-?[0-9]+)((?:\.[^.]*[A-Za-z]|\.[vV][0-9]+)*\.[^.]*[A-Za-z][^.]*)", re.ASCII | re.DOTALL
)
_NUMBER = re.compile(r"-?[0-9]+", re.ASCII)
_PADDING = re.compile("[#@%$<]")  # begins ####, @@@@, %04d, $F4 and <UDIM>
_VERSION = re.compile(r".*(^|[^A-Za-z])[vV]", re.DOTALL)  # matches the shot_v of shot_v02.exr


@dataclass(frozen=True)
class NameForm:
    """The parts of a name: `prefix`, a frame number of at least `padding` digits, `suffix`.

    A padding of 0 means a name without a number.
    """

    prefix: str
    padding: int
    suffix: str

    def name_at(self, frame: int) -> str:
        """Return the file name of `frame`; a sign counts as one of the digits, as in %04d."""
        number = str(frame).zfill(self.padding) if self.padding else ""
        return f"{self.prefix}{number}{self.suffix}"

    def number_in(self, name: str) -> str | None:
        """Return the digits of the number in `name`, of any length; None if it has another form."""
        if not (name.startswith(self.prefix) and name.endswith(self.suffix)):
            return None
        digits = name[len(self.prefix) : len(name) - len(self.suffix)]
        if not _NUMBER.fullmatch(digits) or (digits[0] == "-" and not _allows_sign(self.prefix)):
            return None
        return digits

    def frames_in(self, names: Iterable[str]) -> tuple[int, ...]:
        """Return the sorted frames of `names` that have this form and exactly this padding."""
        numbers = (self.number_in(name) for name in names)
        frames = ((int(number), number) for number in numbers if number is not None)
        return tuple(
            sorted(frame for frame, digits in frames if str(frame).zfill(self.padding) == digits)
        )

    @property
    def text(self) -> str:
        """The name with one # for each digit of the padding."""
        return f"{self.prefix}{'#' * self.padding}{self.suffix}"

    @property
    def is_notation(self) -> bool:
        """True if `text` parses to this form, so the name itself contains no notation marks."""
        return parse_pattern(self.text) == (self, None)


def parse_frame_name(name: str) -> tuple[NameForm, int | None]:
    """Return the form of `name`, and its frame number or None.

    A version (`shot_v02.exr`) is not a frame number, nor is one of more than 20 digits, and a minus
    after a letter or digit is a hyphen.
    """
    match = _NUMBERED.fullmatch(name)
    if not match or _VERSION.fullmatch(match[1]) or len(match[2].lstrip("-")) > _DIGITS_MOST:
        return NameForm(prefix=name, padding=0, suffix=""), None
    prefix, digits, suffix = match.groups()
    if digits[0] == "-" and not _allows_sign(prefix):
        prefix, digits = f"{prefix}-", digits[1:]
    return NameForm(prefix, len(digits), suffix), int(digits)


def parse_pattern(name: str) -> tuple[NameForm, str | None] | None:
    """Parse a notation such as `shot.1001-1100x2####.exr` into its form and its frames, if any.

    A single number after a letter belongs to the name, so `take2####.exr` is take 2. Returns None
    if `name` is not a notation. Raises InputError for more than 20 digits.
    """
    if not _PADDING.search(name):
        return None
    from fileseq.constants import PAD_STYLE_HASH1
    from fileseq.filesequence import FileSequence

    try:
        # In the default style of fileseq, one # stands for four digits.
        parsed = FileSequence(name, pad_style=PAD_STYLE_HASH1)
    except (ValueError, ArithmeticError):  # the latter for numbers of dozens of digits
        return None
    tail = parsed.padding() + parsed.extension()
    if not parsed.padding() or not name.endswith(tail) or _is_tile_or_subframe(parsed.padding()):
        return None
    if parsed.zfill() > _DIGITS_MOST:
        raise InputError(
            f"{name} asks for frame numbers of {parsed.zfill():,} digits: write at most "
            f"{_DIGITS_MOST}, as in #### or %04d."
        )
    head, prefix = name.removesuffix(tail), parsed.basename()
    frames = head.removeprefix(prefix)
    if frames.startswith("-") and not _allows_sign(prefix):
        prefix, frames = f"{prefix}-", frames[1:]
    if frames.isdecimal() and prefix[-1:].isalpha():
        prefix, frames = head, ""
    return NameForm(prefix, padding=parsed.zfill(), suffix=parsed.extension()), frames or None


def parse_frames(text: str) -> tuple[int, ...]:
    """Parse `1001-1100x2` or `1001,1005,1010-1020` into sorted frames.

    Raises InputError if the text cannot be parsed or gives too many frames.
    """
    from fileseq.frameset import FrameSet

    try:
        if re.search(r"\d\s+\d", text):
            raise ValueError("fileseq would join the two numbers")
        frame_set = FrameSet(text)
        count = len(frame_set)
        # A range of millions is not unfolded.
        values = tuple(frame_set) if count <= MAX_FRAMES else ()
    except ValueError as error:  # the base of the errors of fileseq
        raise InputError(_frames_message(text)) from error
    for first, last in re.findall(r"(-?\d+)-(-?\d+)(?!\d|x-)", text):
        if int(last) < int(first):
            raise InputError(f"Frames {first}-{last} run backwards. Give the smaller number first.")
    if count > MAX_FRAMES:
        raise InputError(
            f"Frames {text!r} are {count:,} frames: heatlens takes up to {MAX_FRAMES:,}."
        )
    frames = tuple(sorted(frame for frame in values if isinstance(frame, int)))
    if not frames or len(frames) < len(values):
        raise InputError(_frames_message(text))
    return frames


def frames_text(frames: Iterable[int]) -> str:
    """Return `frames` as ranges such as 1001-1100x2,1200, which `parse_frames` can read."""
    from fileseq.frameset import FrameSet

    return str(FrameSet.framesToFrameRange(frames, sort=True))


def paddings_of(form: NameForm, names: Iterable[str]) -> tuple[int, ...]:
    """Return the lengths that the numbers of `names` in `form` are padded to, usually one.

    Numbers with leading zeros decide; if there are none, the shortest number does.
    """
    numbers = {number for name in names if (number := form.number_in(name)) is not None}
    padded_lengths = {
        len(number) for number in numbers if number.lstrip("-")[0] == "0" and number != "0"
    }
    shortest = min(map(len, numbers), default=0)
    return tuple(sorted(padded_lengths)) or ((shortest,) if shortest else ())


def are_frames(form: NameForm, frames: Sequence[int]) -> bool:
    """Return whether sorted numbers of `form` are frame numbers, and not sizes or versions.

    Frame numbers follow a separator (shot.1001.exr) or have leading zeros. Directly after a letter,
    as in hero720.exr and hero1080.exr, a tenth of the frames from first to last must exist.
    """
    if not form.padding or len(frames) < 2:
        return False
    is_padded = any(len(str(abs(frame))) < form.padding for frame in frames)
    if is_padded or not form.prefix[-1:].isalpha():
        return True
    return len(frames) >= _DENSITY_LEAST * (frames[-1] - frames[0] + 1)


def group_sequences(names: Iterable[str]) -> dict[NameForm, tuple[int, ...]]:
    """Return every form among `names` with its frames, which are () for a name without a number.

    Hidden files are left out, because operating systems and programs add their own.
    """
    groups: dict[NameForm, list[str]] = {}
    for name in names:
        if name.startswith("."):
            continue
        form, number = parse_frame_name(name)
        groups.setdefault(replace(form, padding=0 if number is None else 1), []).append(name)
    sequences = {}
    for form, members in groups.items():
        for padding in paddings_of(form, members) or (0,):
            padded = replace(form, padding=padding)
            sequences[padded] = padded.frames_in(members)
    return sequences


def _allows_sign(prefix: str) -> bool:
    """Return whether a minus after `prefix` can be the sign of a number."""
    return not prefix[-1:].isalnum()


def _is_tile_or_subframe(padding: str) -> bool:
    """Return True for notations of fileseq that are not frame numbers: tiles and sub-frames."""
    return "UDIM" in padding or "." in padding


def _frames_message(text: str) -> str:
    return f"Frames {text!r} cannot be read: write 1001-1100, 1001-1100x2 or 1001,1005,1010-1020."
