"""What shows cached frames on a screen, as the frames rendered ahead know it."""

from dataclasses import dataclass

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.view import ViewState
from heatlens.render.gpu.resources import Texture
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.rendered_frames.cached_pictures import CachedPicture


@dataclass(frozen=True, eq=False)
class CachedFrame(ShownPicture):
    """A frame that was rendered before. `CachedScreen.upload` fills its texture."""

    key: str = ""
    picture: CachedPicture | None = None

    @property
    def is_whole(self) -> bool:
        """True: it was rendered at full quality and the size of the window."""
        return True


class ScreenWork:
    """Shows cached frames on a screen; the base shows none, because it has no screen."""

    @property
    def has_work(self) -> bool:
        """True while a frame in memory is not yet converted for the screen."""
        return False

    def frame_at_playhead(self) -> ShownPicture | None:
        """Return the cached picture of the frame at the playhead; None if there is none."""
        return None

    def upload(self, cached_frame: ShownPicture) -> ShownPicture:
        """Return the same picture with its texture filled."""
        return cached_frame

    def windows(self, cached_frame: ShownPicture) -> tuple[Box, Box] | None:
        """Return data and display window of a cached frame; None if they are the current ones."""
        return None

    def texture(self, cached_frame: CachedFrame, view: ViewState) -> Texture:
        """Return a cached frame in the colors of the screen.

        The exposure of `view` includes the transmission of the lens.
        """
        return cached_frame.texture

    def prepare(self) -> None:
        """Convert one more frame for the screen."""

    def forget_frames(self) -> None:
        """Forget all frames, because another source was opened or they were cleared."""
