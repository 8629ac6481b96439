"""Render the frame through one or several looks in turns, and keep a copy of each picture.

Plates are blurred with the renderer of the window. Looks of a scene can have different fields of
view, so a second renderer draws them in small steps: first a small, quickly blurred picture of each
look, and once all have one, the whole pictures.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Texture
from heatlens.render.gpu.textures import new_texture
from heatlens.render.preview.level_choice import quickest
from heatlens.render.preview.shown import PictureKey, Shown, whole_picture
from heatlens.studio.session.pictures.live_picture import FIRST_PLATE, LivePicture, PlateVersion

_REST_S = 0.08  # without a change for this long, the input rests
_GONE = -1  # plate number of pictures whose plate is no longer loaded
_QUICK = -2  # plate number of quick pictures of a scene
_QUICK_SCALE = 0.25  # scale of the sides of a quick picture


@dataclass
class _Tile:
    """A look: the key of the requested picture, and the latest rendered one."""

    key: PictureKey
    shown: Shown | None = None
    is_refused: bool = False  # the request cannot be rendered, and that was reported

    @property
    def is_done(self) -> bool:
        return self.is_refused or (self.shown is not None and self.shown.picture_key == self.key)

    @property
    def quick_key(self) -> PictureKey:
        """The key of the quick picture of a scene, shown until the whole one is finished."""
        small = (self.key.shot.framing or Framing()).scaled(_QUICK_SCALE)
        settings = quickest(self.key.settings)
        shot = replace(self.key.shot, framing=small, defocus=settings)
        return PictureKey(_QUICK, self.key.frame, shot, settings)

    @property
    def has_quick(self) -> bool:
        """True if there is any picture of this request, quick or whole."""
        return self.is_done or (self.shown is not None and self.shown.picture_key == self.quick_key)


class LookPictures:
    """Renders the requested looks in turns, as one side of the comparison."""

    def __init__(
        self,
        renderer: FrameRenderer,
        live: LivePicture,
    ) -> None:
        """Create it; `live` renders looks of plates, and nothing else while looks are requested."""
        self._renderer = renderer
        self._live = live
        self._clock = time.perf_counter
        self._tiles: dict[str, _Tile] = {}
        self._plate = FIRST_PLATE
        self._budget_s = 0.0
        self._changed_at = 0.0
        self._beside: FrameRenderer | None = None  # the second renderer, for looks of a scene
        self._steps: tuple[PictureKey, Steps[Texture]] | None = None  # its work

    @property
    def shown(self) -> tuple[Shown | None, ...]:
        """The pictures of all looks; each finished picture is a new object."""
        return tuple(tile.shown for tile in self._tiles.values())

    def of(self, name: str) -> Shown | None:
        """Return the latest picture of a look; None before there is one."""
        tile = self._tiles.get(name)
        return None if tile is None else tile.shown

    def is_coming(self, name: str) -> bool:
        """Return True while the whole picture of a look is not finished."""
        tile = self._tiles.get(name)
        return tile is not None and not tile.is_done

    def restart(self) -> None:
        """Start again, because another plate is on the GPU; pictures stay until replaced."""
        self._live.restart()
        self._steps = None
        for tile in self._tiles.values():
            tile.key = replace(tile.key, plate=_GONE)

    def request(
        self,
        shots: Mapping[str, Shot],
        frame: int,
        budget_s: float,
        plate: PlateVersion = FIRST_PLATE,
    ) -> bool:
        """Request these shots, by the names of their looks, at `frame`; return True if it rendered.

        A changed look of a plate is rendered at once as well as `budget_s` allows; looks of a scene
        are rendered when the input rests.
        """
        for name in self._tiles.keys() - shots.keys():
            _release(self._tiles.pop(name).shown)
        if not shots:
            self._let_go()
        self._plate, self._budget_s = plate, budget_s / max(len(shots), 1)
        number = 0 if self._renderer.has_many_views else plate.number  # a scene stays the same
        keys = {name: whole_picture(shot, frame, number) for name, shot in shots.items()}
        changed = [name for name, key in keys.items() if self._is_changed(name, key)]
        if changed:
            self._changed_at = self._clock()
        if self._renderer.has_many_views:
            return False
        for name in changed:
            self._begin(self._tiles[name])
        return bool(changed)

    def _is_changed(self, name: str, key: PictureKey) -> bool:
        """Store the request for a look; return True if it needs a new picture at once."""
        tile = self._tiles.setdefault(name, _Tile(replace(key, plate=_GONE)))
        before, tile.key = tile.key, key
        if before == key:
            return False
        tile.is_refused = False
        is_only_finer = replace(before, plate=key.plate) == key and self._plate.is_finer
        return not (is_only_finer and tile.shown is not None)

    def _begin(self, tile: _Tile) -> None:
        """Start the renderer on a look, and keep the quick picture that it begins with."""
        try:
            self._live.request(tile.key.shot, tile.key.frame, self._budget_s, self._plate)
        except HeatlensError:
            tile.is_refused = True
            raise
        self._keep(tile, self._live.shown)

    def _keep(self, tile: _Tile, made: Shown | None) -> None:
        if made is not None and replace(made.picture_key, settings=tile.key.settings) == tile.key:
            self._copy(tile, made)

    def _copy(self, tile: _Tile, made: Shown) -> None:
        """Keep a copy of a picture, because the renderer reuses its textures."""
        texture = None if tile.shown is None else tile.shown.texture
        if texture is None or texture.size != made.texture.size:
            _release(tile.shown)
            texture = new_texture(self._renderer.ctx, made.texture.size, 4, "f2", "a look")
        self._renderer.copy(made.texture, texture)
        tile.shown = replace(made, texture=texture)

    # A side of the comparison, see `LivePicture`

    is_answering = False  # a changed look of a plate has its quick picture at once

    @property
    def is_working(self) -> bool:
        """True while a whole picture is not finished."""
        return self._next is not None

    @property
    def _next(self) -> _Tile | None:
        """The look to continue; all looks of a scene get a quick picture before any whole one."""
        left = [tile for tile in self._tiles.values() if not tile.is_done]
        if not self._renderer.has_many_views:
            return next(iter(left), None)
        bare = [tile for tile in left if not tile.has_quick]
        return next(iter(bare or left), None)

    def wants_work(self, is_plate_whole: bool = True) -> bool:
        """Return True if there is a picture to continue; False until the plate is whole."""
        return is_plate_whole and self.is_working

    def seconds_to_rest(self) -> float:
        """Return the seconds until a whole picture may be started; 0 if it may start now."""
        own_s = max(0.0, self._changed_at + _REST_S - self._clock())
        return own_s if self._renderer.has_many_views else self._live.seconds_to_rest()

    def work(self, slice_s: float, is_plate_whole: bool = True) -> None:
        """Continue the first look whose picture is not whole, for about `slice_s` seconds."""
        tile = self._next
        if tile is None or not is_plate_whole:
            return
        try:
            if self._renderer.has_many_views:
                self._draw(tile, slice_s)
            else:
                self._blur(tile, slice_s)
        except HeatlensError:
            tile.is_refused, self._steps = True, None
            raise

    def _blur(self, tile: _Tile, slice_s: float) -> None:
        self._live.request(tile.key.shot, tile.key.frame, self._budget_s, self._plate)
        before = self._live.shown
        self._live.work(slice_s)
        if self._live.shown is not before or not self._live.is_working:
            self._keep(tile, self._live.shown)

    def _draw(self, tile: _Tile, slice_s: float) -> None:
        """Continue a look of a scene, which is drawn with the field of view of its lens."""
        key, start = (tile.key if tile.has_quick else tile.quick_key), self._clock()
        if self._steps is None or self._steps[0] != key:
            self._steps = key, self._ready_beside().steps(key.shot, key.frame)
        try:
            while self._clock() - start < slice_s:
                next(self._steps[1])
        except StopIteration as end:
            self._steps = None
            self._copy(tile, Shown(end.value, key.shot, key.frame, key.settings, 0.0, key.plate))

    def _ready_beside(self) -> FrameRenderer:
        """Return the second renderer, loaded with the same scene as the window's."""
        if self._beside is None:
            self._beside = self._renderer.beside()
        if self._beside.scene is not self._renderer.scene:
            self._beside.let_go()
            self._beside.load_scene_of(self._renderer)
        return self._beside

    def _let_go(self) -> None:
        """Free the GPU memory while no look is visible."""
        self._steps = None
        if self._beside is not None and self._beside.has_many_views:
            self._beside.let_go()


def _release(shown: Shown | None) -> None:
    if shown is not None:
        shown.texture.release()
