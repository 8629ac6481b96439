"""The frame through several looks at once: rendered one after the other, each kept as a copy."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from heatlens.errors import HeatlensError
from heatlens.gpu.textures import new_texture
from heatlens.model.shot import Shot
from heatlens.preview.shown import PictureKey, Shown, whole_picture
from heatlens.render import FrameRenderer
from heatlens.session.live_picture import FIRST_PLATE, LivePicture, PlateVersion


@dataclass
class _Tile:
    """One look: the picture that is wished for, and the latest there is."""

    key: PictureKey
    shown: Shown | None = None
    is_refused: bool = False  # it cannot be rendered, as was said

    @property
    def is_done(self) -> bool:
        return self.is_refused or (self.shown is not None and self.shown.picture_key == self.key)


class LookPictures:
    """Renders the wished looks in turns with one `LivePicture`; it is a side of the comparison."""

    def __init__(self, renderer: FrameRenderer, live: LivePicture) -> None:
        self._renderer = renderer
        self._live = live
        self._tiles: dict[str, _Tile] = {}
        self._plate = FIRST_PLATE
        self._budget_s = 0.0

    @property
    def shown(self) -> tuple[Shown | None, ...]:
        """The pictures of all looks; each finished one is another object."""
        return tuple(tile.shown for tile in self._tiles.values())

    def of(self, name: str) -> Shown | None:
        """Return the latest picture of a look; None before there is one."""
        tile = self._tiles.get(name)
        return None if tile is None else tile.shown

    def restart(self) -> None:
        """Begin anew: another plate lies on the GPU. What was made is shown until then."""
        self._live.restart()
        for tile in self._tiles.values():
            tile.key = replace(tile.key, plate=-1)

    def pause(self) -> None:
        """Give up what is half done: others use the renderer now."""
        self._live.pause()

    def wish(
        self,
        shots: Mapping[str, Shot],
        frame: int,
        budget_s: float,
        plate: PlateVersion = FIRST_PLATE,
    ) -> bool:
        """Show these shots, by the names of their looks, at `frame`; return whether it rendered.

        A change is answered at once with what fits `budget_s`.
        """
        for name in self._tiles.keys() - shots.keys():
            _release(self._tiles.pop(name).shown)
        self._plate, self._budget_s = plate, budget_s / max(len(shots), 1)
        changed = [
            self._is_changed(name, whole_picture(shot, frame, plate.number))
            for name, shot in shots.items()
        ]
        for name, is_changed in zip(shots, changed, strict=True):
            if is_changed:
                self._begin(self._tiles[name])
        return any(changed)

    def _is_changed(self, name: str, key: PictureKey) -> bool:
        """Take the wish for a look; return whether it needs another picture at once."""
        tile = self._tiles.setdefault(name, _Tile(replace(key, plate=-1)))
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
        self._keep(tile)

    def _keep(self, tile: _Tile) -> None:
        """Copy the picture that the renderer has now, where it is one of this look."""
        made = self._live.shown
        if made is None or replace(made.picture_key, settings=tile.key.settings) != tile.key:
            return
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
        return next((tile for tile in self._tiles.values() if not tile.is_done), None)

    def wants_work(self, is_plate_whole: bool = True) -> bool:
        """Return True where there is a picture to go on with; none before the plate is whole."""
        return is_plate_whole and self.is_working

    def seconds_to_rest(self) -> float:
        """Return how long until a whole picture may be begun; 0 where it may."""
        return self._live.seconds_to_rest()

    def work(self, slice_s: float, is_plate_whole: bool = True) -> None:
        """Go on with the first look whose picture is not whole, for about `slice_s`."""
        tile = self._next
        if tile is None or not is_plate_whole:
            return
        try:
            self._live.wish(tile.key.shot, tile.key.frame, self._budget_s, self._plate)
            before = self._live.shown
            self._live.work(slice_s, is_plate_whole)
        except HeatlensError:
            tile.is_refused = True
            raise
        if self._live.shown is not before or not self._live.is_working:
            self._keep(tile)


def _release(shown: Shown | None) -> None:
    if shown is not None:
        shown.texture.release()
