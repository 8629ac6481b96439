"""Make a plate of a scene's picture without a lens, with overscan and the surfaces behind it."""

import os
from dataclasses import dataclass

from heatlens.model.shot import Shot
from heatlens.plate.deep.deep_write import check_deep_fits
from heatlens.plate.plate import Plate
from heatlens.render import FrameRenderer
from heatlens.scene_gpu.scene_renderer import PINHOLE_VIEWS
from heatlens.source.scene_plates import with_overscan

AUTO = "auto"


@dataclass(frozen=True)
class PinholeOptions:
    """The options of a plate of a scene.

    overscan  pixels on every side; `AUTO` for as many as the lens needs; None for no overscan
    deep      True to include the surfaces behind the picture
    """

    overscan: int | str | None = None
    deep: bool = False


def pinhole_plate(
    renderer: FrameRenderer,
    shot: Shot,
    frame: int,
    options: PinholeOptions,
    path: str | os.PathLike[str],
) -> Plate:
    """Return the scene's picture at a frame, which will be written to `path`.

    Raises InputError for more overscan than is drawn, and for a deep picture that needs too much
    memory.
    """
    loaded = renderer.look(shot, frame, PINHOLE_VIEWS, is_for_file=options.deep)
    if options == PinholeOptions():
        return loaded.plate
    margin_px = options.overscan or 0
    if isinstance(margin_px, str):
        overscan = loaded.overscan
        margin_px = 0 if overscan is None else overscan.needed_px(renderer.optics(shot, frame))
    if not options.deep:
        return with_overscan(loaded, margin_px)
    width, height = (side + 2 * margin_px for side in loaded.color.size)
    check_deep_fits(path, width, height)
    return with_overscan(loaded, margin_px, loaded.peeled)
