"""Make the key of a rendered frame from all that decides its pixels, and order frames to render."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path

import heatlens
from heatlens.core.base.paths import data_dir
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.media.files.json_record import digest, to_json
from heatlens.media.sequence.sequence import Stamp
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.version import __version__


@dataclass(frozen=True)
class KeySource:
    """The source in front of the lens, as a part of a key.

    name    the file's path, or the name of the scene
    stamps  stamps of the file and of the files that it names; None for missing files
    """

    name: str
    stamps: tuple[Stamp | None, ...]


@dataclass(frozen=True)
class SceneSight:
    """The view of a scene in one frame.

    pose    the pose of the camera
    moment  the frame if something moves, else None
    size    (width, height) of the picture
    """

    pose: Pose
    moment: float | None
    size: tuple[int, int]


def maker_of(renderer: FrameRenderer) -> tuple[str, ...]:
    """Return what identifies the renderer: the program, the graphics driver and the solver."""
    device = renderer.ctx
    driver = device.name, device.version
    return (__version__, program_digest(), *driver, renderer.solver.name)


def shot_key(maker: Sequence[str], options: PlateOptions, defocus: DefocusSettings) -> str:
    """Return a digest of everything that all frames of a shot have in common.

    `options` are those for reading plates; `defocus` has the proxy scale of the cached pictures.
    """
    facts = {"maker": list(maker), "options": to_json(options), "defocus": to_json(defocus)}
    return digest(facts)


def frame_key(shot: str, source: KeySource, lens: Lens, sight: SceneSight | None = None) -> str:
    """Return 32 hexadecimal digits that are equal if the renderer makes the same picture.

    `shot` is the shot's key. The frame number is not included: identical frames share a picture.
    """
    visible_lens = replace(lens.without_advice(), t_stop=None)  # exposure is for the display
    facts: dict[str, object] = {
        "shot": shot,
        "source": to_json(source),
        "lens": to_json(visible_lens),
    }
    if sight is not None:
        facts["sight"] = to_json(sight)
    return digest(facts)


@cache
def program_digest() -> str:
    """Return a digest of the program's files on disk, so that a changed shader has an effect."""
    stamps = {
        str(path): [status.st_mtime_ns, status.st_size]
        for path in _program_files()
        for status in (path.stat(),)
    }
    return digest(stamps)


@cache
def program_contents() -> str:
    """Return a digest of the content of the program's files, which is equal on other machines."""
    digests = (sha256(program_file.read_bytes()) for program_file in _program_files())
    return digest({"files": sorted(it.hexdigest() for it in digests)})


def _program_files() -> list[Path]:
    """Return all files of the program that can decide a pixel."""
    package = Path(heatlens.__file__).parent
    return [*package.rglob("*.py"), *package.rglob("*.json"), *data_dir("shaders").rglob("*.glsl")]


@dataclass(frozen=True)
class PlayOrder:
    """The order in which up to `frames_max` of the played frames are rendered.

    It begins at the playhead and goes in the direction of playback: backward below 0, else forward.
    Playback loops, so the first frame follows the last. A playhead outside the played range counts
    as its beginning.
    """

    playhead: int
    direction: int
    played: FrameRange
    frames_max: int

    @cached_property
    def frames(self) -> tuple[int, ...]:
        """The frames in the order in which they are rendered."""
        played, step = self.played, 1 if self.direction >= 0 else -1
        begin = played.first if step > 0 else played.last
        offset = (self.playhead if self.playhead in played else begin) - played.first
        count = played.count
        return tuple(
            played.first + (offset + i * step) % count for i in range(min(self.frames_max, count))
        )


NO_ORDER = PlayOrder(0, 1, FrameRange(0, 0), 0)


def runs_of(frames: frozenset[int]) -> tuple[FrameRange, ...]:
    """Return the frames as ranges in order, each as long as it can be."""
    runs: list[FrameRange] = []
    for frame in sorted(frames):
        if runs and runs[-1].last == frame - 1:
            runs[-1] = FrameRange(runs[-1].first, frame)
        else:
            runs.append(FrameRange(frame, frame))
    return tuple(runs)
