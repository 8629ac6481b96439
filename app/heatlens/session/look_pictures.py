"""The frame through looks, one or several: rendered one after the other, each kept as a copy.

Plates are blurred with the renderer of the window. A scene may be seen at another angle through
each lens, so that its looks are rendered by a renderer beside that one, in small steps: each look
first as a small picture with a quick blur, and when all of them are seen, each as a whole one.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import moderngl

from heatlens.defocus.pipeline import Steps
from heatlens.errors import HeatlensError
from heatlens.gpu.textures import new_texture
from heatlens.model.framing import Framing
from heatlens.model.shot import Shot
from heatlens.preview.levels import quickest
from heatlens.preview.shown import PictureKey, Shown, whole_picture
from heatlens.render import FrameRenderer
from heatlens.session.live_picture import FIRST_PLATE, LivePicture, PlateVersion

_REST_S = 0.08  # so long without a change is rest
_GONE = -1  # number of a plate that is gone
_QUICK = -2  # number in the place of a plate's, of a quick picture of a scene
_QUICK_SCALE = 0.25  # of its sides


@dataclass
class _Tile:
    """One look: the picture that is wished for, and the latest there is."""

    key: PictureKey
    shown: Shown | None = None
    is_refused: bool = False  # it cannot be rendered, as was said

    @property
    def is_done(self) -> bool:
        return self.is_refused or (self.shown is not None and self.shown.picture_key == self.key)

    @property
    def quick_key(self) -> PictureKey:
        """What the quick picture of a scene is made of, which stands in for the whole one."""
        framing = self.key.shot.framing or Framing()
        width, height = (max(1, round(side * _QUICK_SCALE)) for side in framing.size)
        small = replace(framing, width_px=width, height_px=height)
        settings = quickest(self.key.settings)
        shot = replace(self.key.shot, framing=small, defocus=settings)
        return PictureKey(_QUICK, self.key.frame, shot, settings)

    @property
    def has_quick(self) -> bool:
        """Return True where a picture of this wish is there, however quick."""
        return self.is_done or (self.shown is not None and self.shown.picture_key == self.quick_key)


class LookPictures:
    """Renders the looks that are wished for in turns; it is a side of the comparison."""

    def __init__(
        self,
        renderer: FrameRenderer,
        live: LivePicture,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Take `live`, which renders plates, and nothing else while looks are wished for."""
        self._renderer = renderer
        self._live = live
        self._clock = clock
        self._tiles: dict[str, _Tile] = {}
        self._plate = FIRST_PLATE
        self._budget_s = 0.0
        self._changed_at = 0.0
        self._beside: FrameRenderer | None = None  # renders looks of a scene
        self._steps: tuple[PictureKey, Steps[moderngl.Texture]] | None = None  # of that

    @property
    def shown(self) -> tuple[Shown | None, ...]:
        """The pictures of all looks; each finished one is another object."""
        return tuple(tile.shown for tile in self._tiles.values())

    def of(self, name: str) -> Shown | None:
        """Return the latest picture of a look; None before there is one."""
        tile = self._tiles.get(name)
        return None if tile is None else tile.shown

    def is_coming(self, name: str) -> bool:
        """Return True while the whole picture of a look is not there yet."""
        tile = self._tiles.get(name)
        return tile is not None and not tile.is_done

    def restart(self) -> None:
        """Begin anew: another plate lies on the GPU. What was made is shown until then."""
        self._live.restart()
        self._steps = None
        for tile in self._tiles.values():
            tile.key = replace(tile.key, plate=_GONE)

    def wish(
        self,
        shots: Mapping[str, Shot],
        frame: int,
        budget_s: float,
        plate: PlateVersion = FIRST_PLATE,
    ) -> bool:
        """Show these shots, by the names of their looks, at `frame`; return whether it rendered.

        A change before a plate is answered at once with what fits `budget_s`; a scene is rendered
        when the hand rests.
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
        """Take the wish for a look; return whether it needs another picture at once."""
        tile = self._tiles.setdefault(name, _Tile(replace(key, plate=_GONE)))
        before, tile.key = tile.key, key
        if before == key:
            return False
        tile.is_refused = False
        is_only_finer = replace(before, plate=key.plate) == key and self._plate.is_finer
        return not (is_only_finer and tile.shown is not None)

    def _begin(self, tile: _Tile) -> None:
        """Have the renderer work on a look, and keep the quick picture that it begins with."""
        try:
            self._live.wish(tile.key.shot, tile.key.frame, self._budget_s, self._plate)
        except HeatlensError:
            tile.is_refused = True
            raise
        self._keep(tile, self._live.shown)

    def _keep(self, tile: _Tile, made: Shown | None) -> None:
        """Take a picture that the renderer has made, where it is one of this look."""
        if made is not None and replace(made.picture_key, settings=tile.key.settings) == tile.key:
            self._copy(tile, made)

    def _copy(self, tile: _Tile, made: Shown) -> None:
        """Keep a copy of a picture: the renderer draws over its own."""
        texture = None if tile.shown is None else tile.shown.texture
        if texture is None or texture.size != made.texture.size:
            _release(tile.shown)
            texture = new_texture(self._renderer.ctx, made.texture.size, 4, "f2", "a look")
        self._renderer.copy(made.texture, texture)
        tile.shown = replace(made, texture=texture)

    # A side of the comparison, see `LivePicture`

    @property
    def is_working(self) -> bool:
        """Return True while a whole picture is not there yet."""
        return self._next is not None

    @property
    def _next(self) -> _Tile | None:
        """The look to go on with: each has a quick picture of a scene before one is finished."""
        left = [tile for tile in self._tiles.values() if not tile.is_done]
        if not self._renderer.has_many_views:
            return next(iter(left), None)
        bare = [tile for tile in left if not tile.has_quick]
        return next(iter(bare or left), None)

    def wants_work(self, is_plate_whole: bool = True) -> bool:
        """Return True where there is a picture to go on with; none before the plate is whole."""
        return is_plate_whole and self.is_working

    def seconds_to_rest(self) -> float:
        """Return how long until a whole picture may be begun; 0 where it may."""
        own_s = max(0.0, self._changed_at + _REST_S - self._clock())
        return own_s if self._renderer.has_many_views else self._live.seconds_to_rest()

    def work(self, slice_s: float, is_plate_whole: bool = True) -> None:
        """Go on with the first look whose picture is not whole, for about `slice_s`."""
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
        """Go on with a look of a plate."""
        self._live.wish(tile.key.shot, tile.key.frame, self._budget_s, self._plate)
        before = self._live.shown
        self._live.work(slice_s)
        if self._live.shown is not before or not self._live.is_working:
            self._keep(tile, self._live.shown)

    def _draw(self, tile: _Tile, slice_s: float) -> None:
        """Go on with a look of a scene, which is drawn as its lens sees it."""
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
        """Return the renderer beside that of the window, with the same scene before its lens."""
        if self._beside is None:
            self._beside = self._renderer.beside()
        if self._beside.scene is not self._renderer.scene:
            self._beside.let_go()
            self._beside.load_scene_of(self._renderer)
        return self._beside

    def _let_go(self) -> None:
        """Give the GPU's memory to others while no look is seen."""
        self._steps = None
        if self._beside is not None and self._beside.scene is not None:
            self._beside.let_go()


def _release(shown: Shown | None) -> None:
    if shown is not None:
        shown.texture.release()
