"""The choices of the start screen, and whether it is shown.

Among them are the recently opened files that still exist.
"""

from heatlens.core.base.background import Background
from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Worker
from heatlens.core.base.paths import data_dir
from heatlens.render.source.named import source_named
from heatlens.studio.session.files.file_commands import FileCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.playback import Playback
from heatlens.studio.settings.cards import Card, built_in_cards, recent_card

_RECENT_MAX = 6  # so that all cards together have digit keys


class RecentFiles(Commands, Worker):
    """Checks on a thread which of the remembered files can still be opened."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        stream = shared.command_line.start.stream
        self._stream_names = () if stream is None else (stream.text,)  # the stream comes first
        self._finder: Background[tuple[str, ...]] = Background(self._wake)
        self.existing_names: tuple[str, ...] = ()

    def check(self) -> None:
        """Begin to check the files; `existing_names` has the result a moment later."""
        names = self._preferences.values.recent
        self._finder.start(
            lambda: (*self._stream_names, *(name for name in names if _still_exists(name)))
        )

    @property
    def is_checking(self) -> bool:
        """True while the check is running."""
        return self._finder.is_busy

    @property
    def max_count(self) -> int:
        """The largest number of files that may still be found; 0 once the check has ended."""
        return len(self._preferences.values.recent) if self.is_checking else 0

    def poll(self) -> None:
        """Take the result of the check; call this once a frame."""
        choices = self._finder.poll()
        self.existing_names = self.existing_names if choices is None else choices


def _still_exists(text: str) -> bool:
    """Return True if a file, pattern or folder still exists; runs on a thread."""
    try:
        source_named(text).require()
    except InputError:
        return False
    return True


class StartChoices(Commands):
    """The start screen: whether it is shown, and its choices."""

    def __init__(
        self, shared: Shared, playback: Playback, files: FileCommands, recent: RecentFiles
    ) -> None:
        super().__init__(shared)
        self._playback, self._files, self._recent = playback, files, recent
        self.is_shown = False
        if not self._command_line.start.source:
            self.show()

    def show(self) -> None:
        """Show the start screen instead of the picture; the open source stays open."""
        self.is_shown = True
        self._playback.stop()
        self._recent.check()

    def hide(self) -> None:
        """Leave the start screen, because a source has been opened."""
        self.is_shown = False

    def leave(self) -> None:
        """Go back to the picture, if there is one."""
        if self._source.plate is not None:
            self.is_shown = False

    def show_after_failure(self) -> None:
        """Show the start screen if the source of the command line cannot be opened."""
        is_idle = self._source.opener.opening is None and not self._source.is_waiting
        if is_idle and not self._command_line.has_opened and not self.is_shown:
            self.show()

    @property
    def is_nothing_open(self) -> bool:
        """True if nothing has been opened yet, so that panels would show values of nothing."""
        return self._source.opened is None and not self._source.is_waiting

    @property
    def max_recent_count(self) -> int:
        """The largest number of recent files once the check of them has ended."""
        return min(self._recent.max_count, _RECENT_MAX)

    def cards(self) -> tuple[Card, ...]:
        """Return the permanent choices, then the recent files that still exist."""
        stream = self._source.stream
        still_life_path = str(data_dir("assets") / "still_life.exr")
        stream_cards: tuple[Card, ...] = ()
        if stream is not None:
            words = f"What it sends to {stream.address}"
            stream_cards = (Card("Listen to a renderer", words, stream.text),)
        permanent_cards = (*built_in_cards(still_life_path), *stream_cards)
        listed_texts = {card.text for card in permanent_cards}
        recent_texts = [text for text in self._recent.existing_names if text not in listed_texts]
        return (*permanent_cards, *map(recent_card, recent_texts[:_RECENT_MAX]))

    def open_card(self, card: Card) -> bool:
        """Open a choice; return False if the file dialog is needed.

        The start screen stays until the source is open.
        """
        if card.text is None:
            return False
        self._files.open(card.text)
        stream = self._source.stream
        if stream is not None and card.text == stream.text:
            self.is_shown = False  # the viewport has its own notice while it waits for a stream
        return True
