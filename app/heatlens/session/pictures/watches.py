"""Watch for what concerns every picture: changed shaders, and surfaces that a file has lost."""

from heatlens.gpu import shader_reload
from heatlens.session.loop.worker import Worker
from heatlens.session.pictures.color_choice import ColorChoice
from heatlens.session.shared import Commands, Shared


class ShaderWatch(Commands, Worker):
    """Reports reloaded shaders and has everything drawn again; a mistake in one is only reported.

    It does nothing unless the environment asks for it, see `gpu/shader_reload.py`.
    """

    def __init__(self, shared: Shared, color: ColorChoice) -> None:
        super().__init__(shared)
        self._picture = shared.source.picture
        self._color = color
        self._reload = shader_reload.ShaderReload() if shader_reload.is_on() else None

    def poll(self) -> None:
        """Use changed shaders; call this once a frame."""
        news = None if self._reload is None else self._reload.poll()
        if news is None:
            return
        self._say(news.sentence)
        if news.programs:
            self._picture.count_again()
            self._color.draw_again()

    def seconds_until_needed(self) -> float | None:
        """Return the time between two checks of the files; None if none are checked."""
        return None if self._reload is None else shader_reload.EVERY_S


class LostSurfaces(Commands, Worker):
    """Watches the pictures of a source for notes about lost surfaces."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._noted: tuple[str, ...] = ()
        self._is_reported = False

    def begin(self, notes: tuple[str, ...]) -> None:
        """Begin with another source; `notes` have been reported already."""
        self._noted = notes
        self._is_reported = False

    def poll(self) -> None:
        """Report the note of the first picture that has one."""
        plate = self._source.plate
        if self._is_reported or plate is None or not plate.surfaces_lost:
            return
        self._is_reported = True
        if plate.surfaces_lost not in self._noted:
            self._say(plate.surfaces_lost)
