"""Ask for files to open or save, and pass the choice to the file commands."""

from collections.abc import Callable

from heatlens.session.files.file_commands import PURPOSES, FileCommands
from heatlens.ui.files.file_browser import FileBrowser


class FileDialogs:
    """Opens the file browser for a purpose and applies the choice."""

    def __init__(
        self, files: FileCommands, say: Callable[[str], None], wake: Callable[[], None]
    ) -> None:
        self._files = files
        self.browser = FileBrowser(say, wake)

    def ask(self, key: str) -> None:
        """Ask for a file; `key` is a key of PURPOSES."""
        if self._files.may_choose(key):
            folder, name = self._files.first_folder(key), self._files.first_name(key)
            self.browser.open(PURPOSES[key], folder, name)

    def draw(self) -> None:
        """Draw the dialog if it is open, and apply the user's choice."""
        chosen = self.browser.draw()
        if chosen is not None:
            self._files.take(chosen)
