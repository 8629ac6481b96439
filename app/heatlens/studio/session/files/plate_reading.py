"""The plate options that the user chooses: tried, kept if they work, and remembered."""

from dataclasses import replace
from pathlib import Path

from heatlens.core.model.option import Values
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.sequence.folder_list import Entry
from heatlens.render.source.opened import Opened
from heatlens.studio.session.shared import Commands, Shared


class PlateReading(Commands):
    """Tries options to read the plate with; options that fail leave the plate unchanged."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.options = PlateOptions()
        self._chosen_options: PlateOptions | None = None  # chosen by the user and not loaded yet
        self._shot_options: PlateOptions | None = (
            None  # of the shot at the last `reread_after_undo`
        )

    @property
    def _readable_source(self) -> Opened | None:
        """The open source if its files can be read with other options; None otherwise."""
        opened = self._source.opened
        return None if opened is None or opened.cache is None else opened

    @property
    def is_possible(self) -> bool:
        """True if the open source can be read with other options."""
        return self._readable_source is not None

    @property
    def read_options(self) -> PlateOptions:
        """The options of the plate in the window; other options may have been requested since."""
        opened = self._readable_source
        return self.options if opened is None else opened.options

    @property
    def problem(self) -> str:
        """The reason why the requested options failed; "" if they work or are being tried."""
        opened = self._readable_source
        if opened is None or opened.options == self.options:
            return ""
        if _lacks_depth_ends(self.options):
            return "Give near and far: the distances of the two ends of this depth."
        refused = self._source.opener.failure
        requested = opened.text, self.options
        is_refused = refused is not None and (refused.text, refused.options) == requested
        return refused.message if refused is not None and is_refused else ""

    def change(self, options: PlateOptions) -> None:
        """Read the plate with these options and keep the shot."""
        if options != self.options:
            self.options = options
            if not _lacks_depth_ends(options):
                self._read_with(options)

    def change_matte(self, field: str, matte: str) -> None:
        """Read the plate with another matte in the option called `field`."""
        changes: Values = {field: matte}
        self.change(replace(self.options, **changes))

    def add_behind(self, entry: Entry | None, path: Path) -> None:
        """Read the plate with one more picture of what lies behind: a file, or a pattern.

        A still takes the file of the frame that `entry` of a folder would show.
        """
        opened = self._readable_source
        if entry is not None and opened is not None and opened.frames is None:
            path = entry.file_at(self._editing.frame)
        text = str(path)
        if text not in self.options.behind:
            self.change(replace(self.options, behind=(*self.options.behind, text)))

    def _read_with(self, options: PlateOptions) -> None:
        """Open the source again with other options; the user chose them or an undo brought them."""
        opened = self._readable_source
        if opened is not None:
            self.options = self._chosen_options = options
            self._source.opener.open(opened.text, options, self._editing.frame)

    def remember_options(self, opened: Opened) -> None:
        """Remember options that the user chose for a folder; use those of the source."""
        if opened.cache is not None and opened.options == self._chosen_options:
            self._preferences.remember_options(
                opened.cache.sequence.folder.absolute(), opened.options
            )
        self._chosen_options = None
        self.options = self._shot_options = opened.options

    def reread_after_undo(self) -> None:
        """Read the plate with the options of the shot after an undo or redo."""
        opened, options = self._readable_source, self._editing.shot.plate_options
        if (
            opened is None
            or options == self._shot_options
            or self._editing.shot.source != opened.text
        ):
            return
        self._shot_options = options
        if options != opened.options:
            self._read_with(options)


def _lacks_depth_ends(options: PlateOptions) -> bool:
    """Return True if a normalized depth lacks its near or far distance."""
    needs_ends = options.depth_convention.facts.needs_ends
    return needs_ends and (options.near_m is None or options.far_m is None)
