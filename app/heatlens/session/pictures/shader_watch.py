"""Show pictures with shaders whose files have changed, while shaders are being written."""

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
