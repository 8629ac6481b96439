"""What can be opened from the start screen, and what becomes of the choice."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.documents.shot_file import is_shot_file
from heatlens.files.picture_formats import PICTURES_READ
from heatlens.paths import data_dir, home_dir
from heatlens.scene.scene_source import DEMO
from heatlens.source.kind import SourceKind
from heatlens.source.kind import kind_of as source_kind
from heatlens.ui.actions import Action

if TYPE_CHECKING:
    from heatlens.ui.app import App

_RECENT_MAX = 6  # with what comes before them there are digits for all
# With a key alone; those of the other menus are for a picture, and none is seen.
_MENUS_AWAKE = ("File", "Window", "Help")
_PATTERN_MARKS = "#%@$"


@dataclass(frozen=True)
class Card:
    """One thing to choose.

    title    its name
    words    the line under it
    text     what it opens, as App.open takes it; None: a file is asked for
    kind     of a recent file, in a word; "" for what is always there
    picture  a file in assets/ that shows it, or None
    """

    title: str
    words: str
    text: str | None
    kind: str = ""
    picture: str | None = None


class FirstChoice:
    """Whether the start screen is seen, and what it offers."""

    def __init__(self, app: "App") -> None:
        self._app = app
        self.is_wanted = False
        self._source = app.start.source  # what the command line's options are for
        if not app.start.source:
            self.show()

    def show(self) -> None:
        """Have the start screen in the place of the picture; what is open stays."""
        self.is_wanted = True
        self._app.timeline.playback.stop()
        self._app.filing.find_recent()

    def begun(self, text: str) -> None:
        """It was opened and is seen from now on."""
        self.is_wanted, self._source = False, self._source or text

    def leave(self) -> None:
        """Back to the picture, where there is one."""
        if self._app.source.plate is not None:
            self.is_wanted = False

    def refused(self) -> None:
        """What the program began with cannot be opened: something else can be chosen."""
        source = self._app.source
        is_idle = source.opener.opening is None and not source.is_waiting
        if is_idle and self._app.begun is None and not self.is_wanted:
            self.show()

    @property
    def has_nothing(self) -> bool:
        """Nothing was opened yet that panels could tell of."""
        return self.is_wanted and self._app.source.plate is None

    def sleeps(self, action: Action) -> bool:
        """Its key does nothing while no picture is seen: it may be one of the start screen's."""
        return self.is_wanted and action.menu not in _MENUS_AWAKE

    def came_with(self, text: str) -> bool:
        """Options of the command line are for what it names; else for what is opened first."""
        return self._source in (text, "")

    @property
    def most_recent(self) -> int:
        """As many recent files as there may be once they were looked for."""
        known = len(self._app.filing.preferences.now.recent)
        return min(known, _RECENT_MAX) if self._app.filing.is_looking else 0

    def cards(self) -> tuple[Card, ...]:
        """What is there always, then the recent files that are there."""
        stream = self._app.source.stream
        still = str(data_dir("assets") / "still_life.exr")
        listen = () if stream is None else (_listen(stream.text, stream.address),)
        fixed = (*_built_in(still), *listen)
        known = {card.text for card in fixed}
        recent = [text for text in self._app.filing.recent if text not in known]
        return (*fixed, *map(_recent, recent[:_RECENT_MAX]))

    def take(self, card: Card) -> None:
        """Open it; the start screen stays until it is there."""
        if card.text is None:
            self._app.browse("open")
            return
        self._app.open(card.text)
        stream = self._app.source.stream
        if stream is not None and card.text == stream.text:
            self.is_wanted = False  # the wait for a renderer has words of its own


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
    """What a recent file is, in a word, as far as its name tells."""
    if is_shot_file(text):
        return "Shot"
    if source_kind(text) is SourceKind.SCENE:
        return "3D scene"
    name = Path(text).name
    is_file = name.lower().endswith((".exr", *PICTURES_READ))
    is_one = is_file and not any(mark in name for mark in _PATTERN_MARKS)
    return "Plate" if is_one else "Sequence"
