"""Save the picture to a file or copy it as soon as it is complete."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from heatlens.preview.shown import Shown
from heatlens.session.loop.worker import Worker
from heatlens.session.opened.open_source import OpenSource
from heatlens.session.pictures.live_picture import LivePicture
from heatlens.session.pictures.picture_saver import PictureSaver, Snapshot, snapshot
from heatlens.session.pictures.picture_view import PictureDisplay
from heatlens.session.shot.editing import Editing


class PictureCommands(Worker):
    """Saves and copies the visible picture with the look that the screen gives it."""

    def __init__(
        self,
        source: OpenSource,
        editing: Editing,
        look: PictureDisplay,
        live: LivePicture,
        say: Callable[[str], None],
        wake: Callable[[], None],
    ) -> None:
        self._source = source
        self._editing = editing
        self._look = look
        self._live = live
        self._say = say
        self.saver = PictureSaver(say, wake)

    def save(self, path: Path) -> None:
        """Write the picture of the frame to `path` once it is complete."""
        self.saver.ask(self._editing.shot.source, self._editing.frame, path)

    def copy(self) -> None:
        """Put the picture on the clipboard once it is complete."""
        if self._source.plate is None:
            self._say("Nothing is open to copy.")
        else:
            self.saver.ask(self._editing.shot.source, self._editing.frame, None)

    def close(self) -> None:
        """Wait until a file that is being written is finished."""
        self.saver.close()

    def poll(self) -> None:
        """Continue a requested save or copy; call this once a frame."""
        whole, shot, frame = self._whole(), self._editing.seen_shot, self._editing.frame
        self.saver.poll(whole, shot.source, frame, partial(self._snap, whole))

    def _whole(self) -> Shown | None:
        """Return the picture of the current shot once it is complete."""
        shown, source, frame = self._live.shown, self._source, self._editing.frame
        if source.plate is None or not (source.feed.is_whole and source.is_settled_at(frame)):
            return None
        cache = None if source.opened is None else source.opened.cache
        if cache is not None and source.plate.path != cache.sequence.resolve(frame):
            return None  # the plate of the frame is still being read
        of = (self._editing.seen_shot, frame)
        is_it = shown is not None and (shown.shot, shown.frame) == of
        return shown if is_it and not self._live.is_working else None

    def _snap(self, shown: Shown | None) -> Snapshot:
        """Read the picture back, with the look that it has on the screen."""
        plate = self._source.plate
        assert shown is not None and plate is not None
        return snapshot(shown, plate, self._look.encode)
