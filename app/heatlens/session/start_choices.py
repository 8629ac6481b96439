"""What can be opened from the start screen, and whether that is seen."""

from dataclasses import dataclass
from pathlib import Path

from heatlens.documents.shot_file import is_shot_file
from heatlens.files.picture_formats import PICTURES_READ
from heatlens.paths import data_dir, home_dir
from heatlens.scene.scene_name import DEMO
from heatlens.session.file_commands import FileCommands
from heatlens.session.open_source import OpenSource
from heatlens.session.playback import Playback
from heatlens.session.recent_files import RecentFiles
from heatlens.session.start import GivenOptions
from heatlens.source.kind import SourceKind
from heatlens.source.kind import kind_of as source_kind

_RECENT_MAX = 6  # with what comes before them there are digits for all
_PATTERN_MARKS = "#%@$"


@dataclass(frozen=True)
class Card:
    """One thing to choose.

    title    its name
    words    the line under it
    text     what it opens, as FileCommands.open takes it; None: a file is asked for
    kind     of a recent file, in a word; "" for what is always there
    picture  a file in assets/ that shows it, or None
    """

    title: str
    words: str
    text: str | None
    kind: str = ""
    picture: str | None = None


class StartChoices:
    """Whether the start screen is seen, and what it offers."""

    def __init__(
        self,
        source: OpenSource,
        playback: Playback,
        files: FileCommands,
        recent: RecentFiles,
        given: GivenOptions,
    ) -> None:
        self._source = source
        self._playback = playback
        self._files = files
        self._recent = recent
        self._given = given
        self.is_wanted = False
        if not given.start.source:
            self.show()

    def show(self) -> None:
        """Show the start screen in the place of the picture; what is open stays."""
        self.is_wanted = True
        self._playback.stop()
        self._recent.look()

    def opened(self) -> None:
        """Leave the start screen: something was opened and is seen from now on."""
        self.is_wanted = False

    def leave(self) -> None:
        """Go back to the picture, where there is one."""
        if self._source.plate is not None:
            self.is_wanted = False

    def refused(self) -> None:
        """Show the start screen where what the program began with cannot be opened."""
        is_idle = self._source.opener.opening is None and not self._source.is_waiting
        if is_idle and not self._given.has_opened and not self.is_wanted:
            self.show()

    @property
    def has_nothing(self) -> bool:
        """Return True where nothing was opened yet that panels could tell of."""
        return self.is_wanted and self._source.plate is None

    @property
    def most_recent(self) -> int:
        """As many recent files as there may be once they were looked for."""
        return min(self._recent.most, _RECENT_MAX)

    def cards(self) -> tuple[Card, ...]:
        """Return what is there always, then the recent files that are there."""
        stream = self._source.stream
        still = str(data_dir("assets") / "still_life.exr")
        listen = () if stream is None else (_listen(stream.text, stream.address),)
        fixed = (*_built_in(still), *listen)
        known = {card.text for card in fixed}
        recent = [text for text in self._recent.found if text not in known]
        return (*fixed, *map(_recent, recent[:_RECENT_MAX]))

    def take(self, card: Card) -> bool:
        """Open it; False where a file is to be asked for.

        The start screen stays until it is there.
        """
        if card.text is None:
            return False
        self._files.open(card.text)
        stream = self._source.stream
        if stream is not None and card.text == stream.text:
            self.is_wanted = False  # the wait for a renderer has words of its own
        return True


def _built_in(still: str) -> tuple[Card, ...]:
    return (
        Card("Demo scene", "A street at night, made for focus", DEMO, picture="demo.webp"),
        Card("Still life", "A plate: one frame with depth", still, picture="focus_fruit.png"),
        Card("Open ...", "A plate, a sequence or a 3D scene", None),
    )


def _listen(text: str, address: str) -> Card:
    return Card("Listen to a renderer", f"What it sends to {address}", text)


def _recent(text: str) -> Card:
    path, home = Path(text), home_dir()
    folder = path.parent
    inside = folder.is_relative_to(home) and home != Path(home.anchor)
    words = str(Path("~") / folder.relative_to(home)) if inside else str(folder)
    return Card(path.name, words, text, kind_of(text))


def kind_of(text: str) -> str:
    """Return what a recent file is, in a word, as far as its name tells."""
    if is_shot_file(text):
        return "Shot"
    if source_kind(text) is SourceKind.SCENE:
        return "3D scene"
    name = Path(text).name
    is_file = name.lower().endswith((".exr", *PICTURES_READ))
    is_one = is_file and not any(mark in name for mark in _PATTERN_MARKS)
    return "Plate" if is_one else "Sequence"
