"""Feeds: they bring the pictures of each kind of source to the GPU while the window shows it."""

from dataclasses import dataclass, replace

from heatlens.core.base.background import Background
from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import PROXY_MIN
from heatlens.core.model.shot.shot import Shot
from heatlens.media.frame_cache.cache import Damaged, Direction
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.placing import place_scene
from heatlens.media.scene.scene import Scene
from heatlens.media.sequence.sequence import MissingPolicy
from heatlens.render.rendered_frames.cached_pictures import CachedPicture
from heatlens.render.source.opened_plates import OpenedPlates
from heatlens.render.source.scene_source import OpenedScene
from heatlens.render.source.stream_source import OpenedStream
from heatlens.studio.session.opened.gpu_picture import GpuPicture
from heatlens.studio.session.opened.scene_preview import ScenePreview

# A plate, and the same plate with what its neighboring frames show.
_WithNeighbours = tuple[Plate, Plate]


@dataclass(frozen=True)
class Playhead:
    """The position of the playhead, and the frames that will be requested next.

    direction   the direction in which it moves or last moved
    ahead       how many frames to read ahead in that direction
    missing     the substitute for a frame without a file
    """

    frame: int
    direction: Direction = 1
    is_playing: bool = False
    ahead: int = 0
    missing: MissingPolicy = "hold"


class PictureFeed:
    """The base of all feeds, which brings no pictures: nothing is open yet."""

    def __init__(self, picture: GpuPicture) -> None:
        self.picture = picture
        self.last_request: tuple[int, Direction, int] | None = (
            None  # the last request to a frame cache
        )

    @property
    def scene(self) -> Scene | None:
        """The 3D scene with the shot's placement; None if the source is not a scene."""
        return None

    @property
    def is_good(self) -> bool:
        """True if the picture on the GPU is good enough to be blurred."""
        return True

    @property
    def is_whole(self) -> bool:
        """True if the picture on the GPU has its final quality."""
        return True

    def begin(self) -> None:
        """Show the first picture. If this raises HeatlensError, the previous source stays open."""

    def show(self, shot: Shot, playhead: Playhead) -> None:
        """Have the picture at the playhead on the GPU, now or as soon as it is read."""
        self.picture.request(playhead.frame)

    def update(self, shot: Shot, frame: int) -> None:
        """Update the picture at once after a change of the shot, because the blur needs it."""

    def refine(self, slice_s: float) -> None:
        """Improve the picture for about `slice_s` seconds while nothing moves."""

    def refresh(self) -> None:
        """Load a frame that arrived unrequested. Raises HeatlensError if GPU memory is full."""

    def drawn_shot(self, shot: Shot) -> Shot:
        """Return the shot that is drawn now: a scene is drawn smaller while something moves."""
        return shot

    def windows(self, shot: Shot) -> tuple[Box, Box]:
        """Return data and display window of the whole picture."""
        assert self.picture.plate is not None
        return self.picture.plate.data_window, self.picture.plate.display_window

    def kept_windows(self, picture: CachedPicture) -> tuple[Box, Box] | None:
        """Return the windows of a cached frame; None if they are those of `windows`."""
        return picture.data_window, picture.display_window

    def plate_px(self, shot: Shot, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the plate on the GPU under one of the display window."""
        return pixel

    def scale_shot(self, shot: Shot, scale: float) -> Shot:
        """Return the shot with pictures scaled by `scale`, through its proxy."""
        proxy = max(PROXY_MIN, shot.defocus.proxy * scale)
        return replace(shot, defocus=replace(shot.defocus, proxy=proxy))

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until `refine` has something to do; None if it has nothing."""
        return None


class PlateFeed(PictureFeed):
    """Reads plates ahead of the playhead and uploads the plate at the playhead."""

    def __init__(self, picture: GpuPicture, opened: OpenedPlates) -> None:
        super().__init__(picture)
        self._opened = opened
        self._finder: Background[_WithNeighbours] = Background(opened.counter.count_change)
        self._searched_pair: _WithNeighbours | None = None
        self._searched_plate: Plate | None = None

    def begin(self) -> None:
        """Upload the plate with which the source was opened."""
        self.picture.load(self._opened.plate)
        self.picture.frame, self.picture.is_settled = self._opened.frame, True

    def show(self, shot: Shot, playhead: Playhead) -> None:
        """Show the plate at the playhead; if it cannot be read, set the picture's `problem`."""
        self.picture.request(playhead.frame)
        cache = self._opened.cache
        self.picture.extend_axis(cache.nearest_m)
        try:
            held_frame = cache.sequence.shown_frame(playhead.frame, playhead.missing)
        except InputError as error:
            self.picture.problem, self.picture.is_settled = str(error), True
            return
        if held_frame is None:
            self.picture.is_black = self.picture.is_settled = True
            return
        request = (held_frame, playhead.direction, playhead.ahead)
        if request != self.last_request:
            cache.set_playhead(*request)
            self.last_request = request
        self._show_cached(held_frame, playhead.is_playing)

    def _show_cached(self, frame: int, is_playing: bool) -> None:
        """Show the plate of a frame if it is in the cache, at rest with its neighbors."""
        plate = self._opened.cache.get(frame)
        self.picture.is_settled = plate is not None
        if isinstance(plate, Damaged):
            self.picture.problem = plate.sentence
        elif plate is not None:
            plate_to_show = plate if is_playing else self._with_neighbours(plate)
            if plate_to_show is not self.picture.plate:
                self.picture.load(plate_to_show)

    # A search reads two frames on either side. Only one search runs at a time, because it cannot be
    # stopped and scrubbing passes many plates. The plate itself is shown meanwhile; playback shows
    # nothing else.
    def _with_neighbours(self, plate: Plate) -> Plate:
        """Return the plate with what its neighbors show, or the plate until a thread has that."""
        self._searched_pair = self._finder.poll() or self._searched_pair
        if self._searched_pair is not None and self._searched_pair[0] is plate:
            return self._searched_pair[1]
        if plate is not self._searched_plate and not self._finder.is_busy:
            self._searched_plate = plate
            with_neighbours = self._opened.render_source.read.add_hidden_surfaces
            self._finder.start(lambda: (plate, with_neighbours(plate).plate))
        return plate


class SceneFeed(PictureFeed):
    """Draws the scene: small while something moves, whole and antialiased when it rests."""

    def __init__(self, picture: GpuPicture, opened: OpenedScene) -> None:
        super().__init__(picture)
        self._opened = opened
        self._scene = opened.scene
        self._preview = ScenePreview(picture.renderer)
        self._framing: Framing | None = None  # the framing for which the nearest distance is known
        self._is_playing = False

    @property
    def scene(self) -> Scene:
        return self._scene

    def begin(self) -> None:
        self._load(self._opened.scene)
        self.show(self._opened.first.shot, Playhead(self._opened.frame))

    def _load(self, scene: Scene) -> None:
        """Load another scene into the renderer, and begin its preview."""
        self._scene = scene
        self.picture.renderer.load_scene(scene)
        self.picture.plate = None
        self._preview = ScenePreview(self.picture.renderer)

    def show(self, shot: Shot, playhead: Playhead) -> None:
        """Draw the scene again if it has moved; load it again for another unit or up axis."""
        if shot.framing != self._framing:
            self._framing = shot.framing
            self.picture.reset_axis()
        self.picture.request(playhead.frame)
        self._is_playing = playhead.is_playing
        scene = place_scene(self._scene, shot.framing)
        if scene is not self._scene:  # the shot changed its unit or up axis
            self._load(scene)
        with self.picture.draw_safely():
            self._preview.draw(shot, playhead.frame, playhead.is_playing)
        self.picture.is_settled = True

    def update(self, shot: Shot, frame: int) -> None:
        if self.picture.plate is not None:
            self.show(shot, Playhead(frame, is_playing=self._is_playing))

    def refine(self, slice_s: float) -> None:
        """Go on drawing the scene more finely for `slice_s` seconds."""
        if self.is_whole:
            return
        was_good = self.is_good
        with self.picture.draw_safely():
            self._preview.refine(slice_s)
        self.picture.is_finer = was_good and self._preview.is_whole

    @property
    def is_good(self) -> bool:
        """True if the scene is drawn at full size and antialiased."""
        return bool(self.picture.problem) or self._preview.is_good

    @property
    def is_whole(self) -> bool:
        """True if the scene is drawn at the quality of a file."""
        return bool(self.picture.problem) or self._preview.is_whole

    def drawn_shot(self, shot: Shot) -> Shot:
        return self._preview.drawn_shot(shot)

    def windows(self, shot: Shot) -> tuple[Box, Box]:
        """Return the windows at full size, whatever the size at which the scene is drawn now."""
        box = Box(0, 0, *(shot.framing or Framing()).size)
        return box, box

    def kept_windows(self, picture: CachedPicture) -> None:
        """Return None: cached frames of a scene are smaller, and all have the same window."""

    def plate_px(self, shot: Shot, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the picture, which may be drawn smaller now."""
        if self.picture.plate is None:
            return pixel
        window, (_, whole_window) = self.picture.plate.display_window, self.windows(shot)
        return pixel[0] * window.width // whole_window.width, pixel[
            1
        ] * window.height // whole_window.height

    def scale_shot(self, shot: Shot, scale: float) -> Shot:
        """Return the shot with pictures scaled by `scale`: the scene is drawn at that size."""
        return replace(shot, framing=(shot.framing or Framing()).scaled(scale))

    def seconds_until_needed(self) -> float | None:
        return None if self.is_whole else self._preview.seconds_to_rest()


class StreamFeed(PictureFeed):
    """Shows the newest frame that a renderer has sent, at any position of the playhead."""

    def __init__(self, picture: GpuPicture, opened: OpenedStream) -> None:
        super().__init__(picture)
        self._opened = opened

    def begin(self) -> None:
        self.picture.load(self._opened.plate)
        self.picture.is_settled = True

    def refresh(self) -> None:
        plate = self._opened.stream.poll()
        if plate is not None:
            self.picture.load(plate)
