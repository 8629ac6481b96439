"""The dialog that asks for a file to open or to save."""

from collections.abc import Callable

from heatlens.session.file_commands import PURPOSES, FileCommands
from heatlens.ui.files.file_browser import FileBrowser


class FileDialogs:
    """Opens the browser for a purpose and acts on what is chosen in it."""

    def __init__(
        self, files: FileCommands, say: Callable[[str], None], wake: Callable[[], None]
    ) -> None:
        self._files = files
        self.browser = FileBrowser(say, wake)

    def ask(self, key: str) -> None:
        """Ask for a file; `key` is one of PURPOSES."""
        if self._files.may_choose(key):
            folder, name = self._files.first_folder(key), self._files.first_name(key)
            self.browser.open(PURPOSES[key], folder, name)

    def draw(self) -> None:
        """Draw the dialog where one is open; what is chosen in it is done."""
        chosen = self.browser.draw()
        if chosen is not None:
            self._files.take(chosen)
