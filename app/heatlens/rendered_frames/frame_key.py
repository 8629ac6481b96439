"""By what a rendered frame is known again: all that decides its pixels, and nothing else."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import heatlens
from heatlens import __version__
from heatlens.files.json_record import plain
from heatlens.model.framing import Pose
from heatlens.model.lens import Lens
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import DefocusSettings
from heatlens.paths import data_dir
from heatlens.plate.picture_digest import digest, without_advice
from heatlens.render import FrameRenderer
from heatlens.sequence.sequence import Stamp


@dataclass(frozen=True)
class KeySource:
    """The source before the lens, as a part of a key.

    name    the file's path, or the name of the scene
    stamps  of the file and of those that it names; None where there is none
    """

    name: str
    stamps: tuple[Stamp | None, ...]


@dataclass(frozen=True)
class SceneSight:
    """How a scene is looked at in one frame.

    pose    where the camera stands
    moment  the frame, where something moves; None where nothing does
    size    of the picture, (width, height)
    """

    pose: Pose
    moment: float | None
    size: tuple[int, int]


def maker_of(renderer: FrameRenderer) -> tuple[str, ...]:
    """Return what renders: the program, the graphics driver and the solver."""
    info = renderer.ctx.info
    driver = str(info["GL_RENDERER"]), str(info["GL_VERSION"])
    return (__version__, program_digest(), *driver, renderer.solver.name)


def shot_key(maker: Sequence[str], options: PlateOptions, defocus: DefocusSettings) -> str:
    """Return a digest of what all frames of a shot have in common.

    `options` say how a plate is read; `defocus` has the proxy of the pictures that are kept.
    """
    facts = {"maker": list(maker), "options": plain(options), "defocus": plain(defocus)}
    return digest(facts)


def frame_key(shot: str, source: KeySource, lens: Lens, sight: SceneSight | None = None) -> str:
    """Return 32 hexadecimal digits: equal where the renderer makes the same picture.

    `shot` is the shot's key. The number of the frame does not count: frames at which nothing
    differs share one picture.
    """
    seen = replace(without_advice(lens), t_stop=None)  # exposure is for the display
    facts: dict[str, Any] = {"shot": shot, "source": plain(source), "lens": plain(seen)}
    if sight is not None:
        facts["sight"] = plain(sight)
    return digest(facts)


@cache
def program_digest() -> str:
    """Return a digest of the program's files as they are on disk.

    Whoever changes a shader sees pictures by the new one.
    """
    package = Path(heatlens.__file__).parent
    files = [*package.rglob("*.py"), *package.rglob("*.json"), *data_dir("shaders").rglob("*.glsl")]
    stamps = {str(path): [s.st_mtime_ns, s.st_size] for path in files for s in (path.stat(),)}
    return digest(stamps)
