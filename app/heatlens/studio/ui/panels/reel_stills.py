"""Keep the stills of the shots of a reel as textures, in the colors of the screen."""

from dataclasses import dataclass, replace

from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.view.view import Compare
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.resources import Texture
from heatlens.studio.board.board import Board
from heatlens.studio.board.controls import FileControl, PictureControl
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.picture.picture_alone import PictureAlone

_MAX_UPLOADS = 2  # in one frame of the window
_SCENE_STILL_PX = 128, 72


@dataclass
class _Still:
    """A still of a shot.

    light    the first plate, scene-linear; None for a scene, whose still is drawn
    texture  the still in the colors of the screen
    look     exposure, gamma and version of the view transform of `texture`
    """

    light: Texture | None
    texture: Texture
    look: tuple[object, ...]

    def release(self) -> None:
        self.texture.release()
        if self.light is not None:
            self.light.release()


# A still keeps scene-linear light and goes through the view transform of the window, so it looks
# like the shot on the screen; this is repeated when exposure, gamma or view change. At most two
# stills are uploaded in a frame, so that opening a long reel does not block the window.
class ReelStills:
    """Textures of the stills that were visible so far, of one reel at a time."""

    def __init__(self, board: Board, control: PictureControl, screen: ScreenPictures) -> None:
        self._board, self._control, self._screen = board, control, screen
        self._picture = PictureAlone(control.renderer.ctx)
        self._reel: Reel | None = None
        self._stills: dict[ReelShot, _Still] = {}
        self._uploads = 0

    def begin(self, files: FileControl, pictures: Pictures | None) -> None:
        """Drop stills of shots that are not in the reel, and draw the still of an open scene.

        Call this before the strip is drawn; `pictures` are those in the viewport.
        """
        self._uploads, reel = 0, files.reel
        if reel.reel is not self._reel:
            shots = () if reel.reel is None else reel.reel.shots
            for shot in self._stills.keys() - set(shots):
                self._stills.pop(shot).release()
            self._reel = reel.reel
        picture = self._control.live.output
        is_shown = picture is not None and picture.is_whole and self._board.facts.is_live_alone
        if pictures is not None and is_shown and self._board.facts.has_camera and reel.is_open:
            assert reel.reel is not None
            self._draw_scene_still(reel.reel.shots[reel.number], pictures)

    def texture_of(self, files: FileControl, number: int) -> Texture | None:
        """Return the still of a shot, the bottom row first; None if there is none yet."""
        assert self._reel is not None
        still = self._stills.get(self._reel.shots[number])
        if still is None and self._uploads < _MAX_UPLOADS:
            still = self._upload(files, number)
        if still is None:
            return None
        if still.light is not None and still.look != self._look:
            self._screen.draw_still(still.texture, still.light, self._board.facts.view)
            still.look = self._look
        return still.texture

    def _upload(self, files: FileControl, number: int) -> _Still | None:
        """Upload the still of a shot and return it; None if it is not read yet."""
        pixels = files.reel.still_of(number)
        if pixels is None or self._reel is None:
            return None
        self._uploads += 1
        height, width = pixels.shape[:2]
        ctx = self._control.renderer.ctx
        light = ctx.texture((width, height), 4, pixels[::-1].tobytes(), dtype="f2")
        texture = self._screen.draw_still(None, light, self._board.facts.view)
        still = self._stills[self._reel.shots[number]] = _Still(light, texture, self._look)
        return still

    def _draw_scene_still(self, shot: ReelShot, pictures: Pictures) -> None:
        """Draw the picture of the open scene as its still, once for each view transform."""
        old_still = self._stills.get(shot)
        if old_still is not None and old_still.look == self._look:
            return
        plain_view = replace(self._board.facts.view, compare=Compare.OFF)
        self._picture.draw(replace(pictures, tiles=()), plain_view, _SCENE_STILL_PX)
        if old_still is not None:
            old_still.release()
        self._stills[shot] = _Still(None, self._picture.detach_texture(), self._look)

    @property
    def _look(self) -> tuple[object, ...]:
        """Return what the colors of the stills depend on besides their light."""
        view = self._board.facts.view
        return view.exposure_stops, view.gamma, self._screen.transform_version
