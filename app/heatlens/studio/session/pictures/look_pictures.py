"""Render the frame through one or several looks in turn, and keep a copy of each picture.

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
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import new_texture
from heatlens.render.preview.level_choice import fastest_settings
from heatlens.render.preview.shown import PictureKey, ShownPicture, whole_picture
from heatlens.studio.session.pictures.live_picture import FIRST_PLATE, LivePicture, PlateVersion

_REST_S = 0.08  # without a change for this long, the input rests
_GONE = -1  # plate number of pictures whose plate is no longer loaded
_QUICK = -2  # plate number of quick pictures of a scene
_QUICK_SCALE = 0.25  # scale of the sides of a quick picture


@dataclass
class _Tile:
    """A look: the key of the requested picture, and the latest rendered one."""

    key: PictureKey
    picture: ShownPicture | None = None
    is_refused: bool = False  # the request cannot be rendered, and that was reported

    @property
    def is_finished(self) -> bool:
        """True if the requested picture is rendered, or cannot be."""
        return self.is_refused or (
            self.picture is not None and self.picture.picture_key == self.key
        )

    @property
    def quick_key(self) -> PictureKey:
        """The key of the quick picture of a scene, shown until the whole one is finished."""
        small = (self.key.shot.framing or Framing()).scaled(_QUICK_SCALE)
        settings = fastest_settings(self.key.settings)
        shot = replace(self.key.shot, framing=small, defocus=settings)
        return PictureKey(_QUICK, self.key.frame, shot, settings)

    @property
    def has_quick(self) -> bool:
        """True if there is any picture of this request, quick or whole."""
        return self.is_finished or (
            self.picture is not None and self.picture.picture_key == self.quick_key
        )


class LookPictures:
    """Renders the requested looks in turns, as one side of the comparison."""

    def __init__(self, renderer: FrameRenderer, live: LivePicture) -> None:
        """Create it; `live` renders looks of plates, and nothing else while looks are requested."""
        self._renderer = renderer
        self._live = live
        self._clock = time.perf_counter
        self._tiles: dict[str, _Tile] = {}
        self._plate = FIRST_PLATE
        self._budget_s = 0.0
        self._changed_at = 0.0
        self._second_renderer: FrameRenderer | None = (
            None  # the second renderer, for looks of a scene
        )
        self._steps: tuple[PictureKey, Steps[Texture]] | None = None  # its work

    @property
    def output(self) -> tuple[ShownPicture | None, ...]:
        """The pictures of all looks; each finished picture is a new object."""
        return tuple(tile.picture for tile in self._tiles.values())

    def picture_of(self, name: str) -> ShownPicture | None:
        """Return the latest picture of a look; None before there is one."""
        tile = self._tiles.get(name)
        return None if tile is None else tile.picture

    def is_unfinished(self, name: str) -> bool:
        """Return True while the whole picture of a look is not finished."""
        tile = self._tiles.get(name)
        return tile is not None and not tile.is_finished

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
            _release(self._tiles.pop(name).picture)
        if not shots:
            self._free_memory()
        self._plate, self._budget_s = plate, budget_s / max(len(shots), 1)
        number = 0 if self._renderer.has_many_views else plate.number  # a scene stays the same
        keys = {name: whole_picture(shot, frame, number) for name, shot in shots.items()}
        changed_names = [name for name, key in keys.items() if self._is_changed(name, key)]
        if changed_names:
            self._changed_at = self._clock()
        if self._renderer.has_many_views:
            return False
        for name in changed_names:
            self._render_quick(self._tiles[name])
        return bool(changed_names)

    def _is_changed(self, name: str, key: PictureKey) -> bool:
        """Store the request for a look; return True if it needs a new picture at once."""
        tile = self._tiles.setdefault(name, _Tile(replace(key, plate=_GONE)))
        old_key, tile.key = tile.key, key
        if old_key == key:
            return False
        tile.is_refused = False
        is_only_finer = replace(old_key, plate=key.plate) == key and self._plate.is_finer
        return not (is_only_finer and tile.picture is not None)

    def _render_quick(self, tile: _Tile) -> None:
        """Start the renderer on a look, and keep the quick picture that it begins with."""
        try:
            self._live.request(tile.key.shot, tile.key.frame, self._budget_s, self._plate)
        except HeatlensError:
            tile.is_refused = True
            raise
        # the renderer still shows its last picture if it has not drawn one of this look yet
        self._store_if_requested(tile, self._live.output)

    def _store_if_requested(self, tile: _Tile, picture: ShownPicture | None) -> None:
        """Store a copy of a picture if it is that of the look's request, at any quality."""
        if (
            picture is not None
            and replace(picture.picture_key, settings=tile.key.settings) == tile.key
        ):
            self._store_copy(tile, picture)

    def _store_copy(self, tile: _Tile, picture: ShownPicture) -> None:
        """Keep a copy of a picture, because the renderer reuses its textures."""
        texture = None if tile.picture is None else tile.picture.texture
        if texture is None or texture.size != picture.texture.size:
            _release(tile.picture)
            texture = new_texture(self._renderer.ctx, picture.texture.size, 4, "f2", "a look")
        self._renderer.copy(picture.texture, texture)
        tile.picture = replace(picture, texture=texture)

    # A side of the comparison, see `LivePicture`

    is_answering = False  # a changed look of a plate has its quick picture at once

    @property
    def is_working(self) -> bool:
        """True while a whole picture is not finished."""
        return self._next_tile is not None

    @property
    def _next_tile(self) -> _Tile | None:
        """The look to continue; all looks of a scene get a quick picture before any whole one."""
        unfinished = [tile for tile in self._tiles.values() if not tile.is_finished]
        if not self._renderer.has_many_views:
            return next(iter(unfinished), None)
        without_quick = [tile for tile in unfinished if not tile.has_quick]
        return next(iter(without_quick or unfinished), None)

    def has_work(self, is_plate_whole: bool = True) -> bool:
        """Return True if there is a picture to continue; False until the plate is whole."""
        return is_plate_whole and self.is_working

    def seconds_to_rest(self) -> float:
        """Return the seconds until a whole picture may be started; 0 if it may start now."""
        scene_rest_s = max(0.0, self._changed_at + _REST_S - self._clock())
        return scene_rest_s if self._renderer.has_many_views else self._live.seconds_to_rest()

    def work(self, slice_s: float, is_plate_whole: bool = True) -> None:
        """Continue the first unfinished look for about `slice_s` seconds; an error refuses it."""
        tile = self._next_tile
        if tile is None or not is_plate_whole:
            return
        try:
            if self._renderer.has_many_views:
                self._draw_scene(tile, slice_s)
            else:
                self._blur_plate(tile, slice_s)
        except HeatlensError:
            tile.is_refused, self._steps = True, None
            raise

    def _blur_plate(self, tile: _Tile, slice_s: float) -> None:
        """Continue a look of a plate for a slice of time, and store its picture."""
        self._live.request(tile.key.shot, tile.key.frame, self._budget_s, self._plate)
        old_output = self._live.output
        self._live.work(slice_s)
        if self._live.output is not old_output or not self._live.is_working:
            self._store_if_requested(tile, self._live.output)

    def _draw_scene(self, tile: _Tile, slice_s: float) -> None:
        """Continue a look of a scene, which is drawn with the field of view of its lens."""
        key, start = (tile.key if tile.has_quick else tile.quick_key), self._clock()
        if self._steps is None or self._steps[0] != key:
            self._steps = key, self._prepare_second_renderer().steps(key.shot, key.frame)
        try:
            while self._clock() - start < slice_s:
                next(self._steps[1])
        except StopIteration as end:
            self._steps = None
            self._store_copy(
                tile, ShownPicture(end.value, key.shot, key.frame, key.settings, 0.0, key.plate)
            )

    def _prepare_second_renderer(self) -> FrameRenderer:
        """Return the second renderer, loaded with the same scene as the window's."""
        if self._second_renderer is None:
            self._second_renderer = self._renderer.make_sibling()
        if self._second_renderer.scene is not self._renderer.scene:
            self._second_renderer.unload()
            self._second_renderer.load_scene_of(self._renderer)
        return self._second_renderer

    def _free_memory(self) -> None:
        """Free the GPU memory while no look is visible."""
        self._steps = None
        if self._second_renderer is not None and self._second_renderer.has_many_views:
            self._second_renderer.unload()


def _release(picture: ShownPicture | None) -> None:
    """Free the texture of a picture, if there is one."""
    if picture is not None:
        picture.texture.release()
