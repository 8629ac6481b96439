"""The stills of the shots of a reel, as the screen shows them."""

from dataclasses import dataclass, replace

import moderngl

from heatlens.display.screen_pictures import ScreenPictures
from heatlens.model.shot.reel import Reel
from heatlens.model.view.view import Compare
from heatlens.session.desks import PictureDesk
from heatlens.session.facts import Facts
from heatlens.session.files.open_reel import OpenReel
from heatlens.ui.picture.grid import Pictures
from heatlens.ui.picture.picture_alone import PictureAlone

_UPLOADS_MOST = 2  # in one frame of the window
_DRAWN_PX = 128, 72


@dataclass
class _Still:
    """A still, and what it shows.

    light   the first plate, scene-linear; None in the still of a scene, which was drawn
    shown   what the screen shows
    look    exposure, gamma and version of the view transform of `shown`
    """

    light: moderngl.Texture | None
    shown: moderngl.Texture
    look: tuple[object, ...]

    def release(self) -> None:
        self.shown.release()
        if self.light is not None:
            self.light.release()


class ReelStills:
    """Textures of the rows that were seen; those of one reel at a time."""

    def __init__(self, facts: Facts, desk: PictureDesk, screen: ScreenPictures) -> None:
        self._facts, self._desk, self._screen = facts, desk, screen
        self._alone = PictureAlone(desk.renderer.ctx)
        self._reel: Reel | None = None
        self._stills: dict[int, _Still] = {}
        self._uploads = 0

    def begin(self, reel: OpenReel, pictures: Pictures | None) -> None:
        """Drop those of another reel, and take the picture of an open scene.

        Call this before the rows are drawn; `pictures` are those in the viewport.
        """
        self._uploads = 0
        if reel.reel is not self._reel:
            for still in self._stills.values():
                still.release()
            self._stills, self._reel = {}, reel.reel
        seen = self._desk.live.shown
        is_seen = seen is not None and seen.is_whole and self._facts.is_plain
        if pictures is not None and is_seen and self._facts.has_camera and reel.is_open:
            self._take(reel.at, pictures)

    def of(self, reel: OpenReel, number: int) -> moderngl.Texture | None:
        """Return the still of a shot, the bottom row first; None if there is none yet."""
        still = self._stills.get(number)
        if still is None and self._uploads < _UPLOADS_MOST:
            still = self._uploaded(reel, number)
        if still is None:
            return None
        if still.light is not None and still.look != self._look:
            self._screen.still(still.shown, still.light, self._facts.view)
            still.look = self._look
        return still.shown

    def _uploaded(self, reel: OpenReel, number: int) -> _Still | None:
        pixels = reel.still_of(number)
        if pixels is None:
            return None
        self._uploads += 1
        height, width = pixels.shape[:2]
        ctx = self._desk.renderer.ctx
        light = ctx.texture((width, height), 4, pixels[::-1].tobytes(), dtype="f2")
        shown = self._screen.still(None, light, self._facts.view)
        self._stills[number] = still = _Still(light, shown, self._look)
        return still

    def _take(self, number: int, pictures: Pictures) -> None:
        """Draw the picture of the open scene as its still, once for each view transform."""
        before = self._stills.get(number)
        if before is not None and before.look == self._look:
            return
        plain = replace(self._facts.view, compare=Compare.OFF)
        self._alone.draw(replace(pictures, tiles=()), plain, _DRAWN_PX)
        if before is not None:
            before.release()
        self._stills[number] = _Still(None, self._alone.hand_over(), self._look)

    @property
    def _look(self) -> tuple[object, ...]:
        view = self._facts.view
        return view.exposure_stops, view.gamma, self._screen.transform_version
