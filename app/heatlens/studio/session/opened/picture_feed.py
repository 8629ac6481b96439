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
from heatlens.media.scene.placing import placed
from heatlens.media.scene.scene import Scene
from heatlens.media.sequence.sequence import MissingPolicy
from heatlens.render.rendered_frames.kept_pictures import KeptPicture
from heatlens.render.source.opened_plates import OpenedPlates
from heatlens.render.source.scene_source import OpenedScene
from heatlens.render.source.stream_source import OpenedStream
from heatlens.studio.session.opened.gpu_picture import GpuPicture
from heatlens.studio.session.opened.scene_preview import ScenePreview

# A plate, and the same with what its neighbours show.
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
        self.wanted: tuple[int, Direction, int] | None = None  # the last request to a frame cache

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
        self.picture.ask(playhead.frame)

    def follow(self, shot: Shot, frame: int) -> None:
        """Answer a change of the shot since `show` at once, as the blur needs the new picture."""

    def refine(self, slice_s: float) -> None:
        """Improve the picture for about `slice_s` seconds while nothing moves."""

    def refresh(self) -> None:
        """Take over unrequested frames that arrived. Raises HeatlensError if GPU memory is full."""

    def seen(self, shot: Shot) -> Shot:
        """Return the shot that is drawn now: a scene is drawn smaller while something moves."""
        return shot

    def windows(self, shot: Shot) -> tuple[Box, Box]:
        """Return data and display window of the whole picture."""
        assert self.picture.plate is not None
        return self.picture.plate.data_window, self.picture.plate.display_window

    def kept_windows(self, picture: KeptPicture) -> tuple[Box, Box] | None:
        """Return the windows of a kept frame; None if they are those of `windows`."""
        return picture.data_window, picture.display_window

    def plate_px(self, shot: Shot, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the plate on the GPU under one of the display window."""
        return pixel

    def sized(self, shot: Shot, scale: float) -> Shot:
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
        self._finder: Background[_WithNeighbours] = Background(opened.counter.tell)
        self._found: _WithNeighbours | None = None
        self._looked_at: Plate | None = None

    def begin(self) -> None:
        self.picture.load(self._opened.plate)
        self.picture.frame, self.picture.is_settled = self._opened.frame, True

    def show(self, shot: Shot, playhead: Playhead) -> None:
        """Show the plate there; why it cannot be read becomes the picture's `problem`."""
        self.picture.ask(playhead.frame)
        cache = self._opened.cache
        self.picture.reach(cache.nearest_m)
        try:
            stands_in = cache.sequence.shown_frame(playhead.frame, playhead.missing)
        except InputError as error:
            self.picture.problem, self.picture.is_settled = str(error), True
            return
        if stands_in is None:
            self.picture.is_black = self.picture.is_settled = True
            return
        wanted = (stands_in, playhead.direction, playhead.ahead)
        if wanted != self.wanted:
            cache.want(*wanted)
            self.wanted = wanted
        self._take(stands_in, playhead.is_playing)

    def _take(self, frame: int, is_playing: bool) -> None:
        plate = self._opened.cache.get(frame)
        self.picture.is_settled = plate is not None
        if isinstance(plate, Damaged):
            self.picture.problem = plate.sentence
        elif plate is not None:
            shown = plate if is_playing else self._with_neighbours(plate)
            if shown is not self.picture.plate:
                self.picture.load(shown)

    # A search reads two frames on either side. A hand that scrubs passes many plates, and each
    # began a search on a thread of its own, none of which could be stopped. The plate itself is
    # shown meanwhile; playback shows nothing else.
    def _with_neighbours(self, plate: Plate) -> Plate:
        """Return the plate with what its neighbours show, once that is found on a thread."""
        self._found = self._finder.poll() or self._found
        if self._found is not None and self._found[0] is plate:
            return self._found[1]
        # One search at a time: scrubbing passes many plates.
        if plate is not self._looked_at and not self._finder.is_busy:
            self._looked_at = plate
            with_neighbours = self._opened.again.read.found
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
        self._scene = scene
        self.picture.renderer.load_scene(scene)
        self.picture.plate = None
        self._preview = ScenePreview(self.picture.renderer)

    def show(self, shot: Shot, playhead: Playhead) -> None:
        """Draw the scene again if something has moved."""
        if shot.framing != self._framing:
            self._framing = shot.framing
            self.picture.begin_axis()
        self.picture.ask(playhead.frame)
        self._is_playing = playhead.is_playing
        scene = placed(self._scene, shot.framing)
        if scene is not self._scene:  # the shot changed its unit or up axis
            self._load(scene)
        with self.picture.drawing():
            self._preview.look(shot, playhead.frame, playhead.is_playing)
        self.picture.is_settled = True

    def follow(self, shot: Shot, frame: int) -> None:
        if self.picture.plate is not None:
            self.show(shot, Playhead(frame, is_playing=self._is_playing))

    def refine(self, slice_s: float) -> None:
        if self.is_whole:
            return
        was_good = self.is_good
        with self.picture.drawing():
            self._preview.refine(slice_s)
        self.picture.is_finer = was_good and self._preview.is_whole

    @property
    def is_good(self) -> bool:
        """Large and antialiased."""
        return bool(self.picture.problem) or self._preview.is_good

    @property
    def is_whole(self) -> bool:
        """At the quality of a file."""
        return bool(self.picture.problem) or self._preview.is_whole

    def seen(self, shot: Shot) -> Shot:
        return self._preview.seen(shot)

    def windows(self, shot: Shot) -> tuple[Box, Box]:
        """Return the windows, whatever the size at which it is drawn now."""
        box = Box(0, 0, *(shot.framing or Framing()).size)
        return box, box

    def kept_windows(self, picture: KeptPicture) -> None:
        """Return None: kept frames of a scene are smaller, and all have the same window."""

    def plate_px(self, shot: Shot, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the picture, which may be drawn smaller now."""
        if self.picture.plate is None:
            return pixel
        window, (_, whole) = self.picture.plate.display_window, self.windows(shot)
        return pixel[0] * window.width // whole.width, pixel[1] * window.height // whole.height

    def sized(self, shot: Shot, scale: float) -> Shot:
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
