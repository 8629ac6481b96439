"""Build the programs of a source's pictures, run as a process beside a window.

It renders the previews and the whole picture of one frame, and so fills the driver's cache. After
each picture it writes the digests of its new programs, in one line. It never outlives the calling
process.
"""

import os
import pickle
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace

from heatlens.core.base.stopping import die_with_parent, lower_priority
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.render.frame_renderer import FrameRenderer, headless_renderer, run_all_steps
from heatlens.render.gpu import shader_reload
from heatlens.render.gpu.context import is_software
from heatlens.render.preview.level_choice import useful_levels
from heatlens.render.scene_gpu.pinhole_draw import PINHOLE_VIEWS
from heatlens.render.source.source import Source

_SMALL_SCENE = 1 / 4  # the scale at which a window draws a scene first
_URGENT_COUNT = 4  # pictures that a window waits for: the quickest ones and the whole one
# A lens that focuses nearer or farther blurs in other sizes, for which programs differ.
_FOCUS_FACTORS, _SMALL_PROXY = (1.0, 0.4, 4.0), 1 / 4


@dataclass(frozen=True)
class BuildRequest:
    """The pictures of one frame of a source to render, each the shot with other settings."""

    source: Source
    frame: int
    pictures: tuple[Shot, ...]


def pictures_to_build(renderer: FrameRenderer, shot: Shot, frame: int) -> tuple[Shot, ...]:
    """Return the pictures that a window may show of a frame.

    The quickest come first, then the whole picture, then the previews between them.
    """
    shot = replace(shot, lens=shot.lens_at(frame), curves=LensCurves())
    framing, settings = shot.framing or Framing(), shot.defocus
    small = replace(shot, framing=framing.scaled(_SMALL_SCENE))
    has_many_views = renderer.has_many_views
    quick = [
        replace(sized, defocus=level, lens=lens)
        for sized in ((shot, small) if has_many_views else (shot,))
        for level in useful_levels(settings, renderer.size(sized), has_many_views)[:0:-1]
        for lens in _lenses(shot.lens, level)
    ]
    # A hand that drags waits for all of the quickest level: with the whole picture before its last
    # ones, no drag of the first 20 s of a plate had a picture of diffusion.
    quickest = [picture for picture in quick if picture.defocus == quick[0].defocus]
    return (*quickest, shot, *(picture for picture in quick if picture not in quickest))


def _lenses(lens: Lens, level: DefocusSettings) -> Iterator[Lens]:
    """Yield the lens, for small pictures with other focus distances too."""
    for factor in _FOCUS_FACTORS if level.proxy <= _SMALL_PROXY else (1.0,):
        yield replace(lens, focus_distance_m=lens.focus_distance_m * factor)


# A software rasterizer compiles a program for each kind of texture that it reads. It changes the
# program thereby, and keeps what it compiles next under the name of the changed one, where no other
# process finds it. So each picture is rendered twice by programs that were not compiled yet: the
# first kinds of the second time are on the disk, and the next are kept under their true names. Only
# small pictures of a scene are antialiased, by the programs that also antialias the large ones.
def build_programs(request: BuildRequest) -> None:
    """Render every picture of a request; write a line after each."""
    renderer, frame, shot = headless_renderer(), request.frame, request.pictures[0]
    loader = request.source.loader(shot, (request.source.origin(shot, frame, "hold"),), renderer)
    if not renderer.has_many_views:
        loader.load(request.source.origin(shot, frame, "hold"))
    written: set[str] = set()
    built = renderer.ctx.known_programs.digests
    for number, picture in enumerate(request.pictures):
        if number == _URGENT_COUNT:
            lower_priority()  # once more
        for _ in range(1 + is_software(renderer.ctx)):
            shader_reload.rebuild_used()
            for views in (1, PINHOLE_VIEWS) if picture.framing != shot.framing else (1,):
                renderer.load_pinhole(picture, frame, views)
            run_all_steps(renderer.steps(picture, frame, enlarges=picture.defocus.proxy < 1.0))
            renderer.ctx.finish()
        sys.stdout.write(" ".join(built - written) + "\n")
        sys.stdout.flush()
        written = set(built)
    loader.close()


if __name__ == "__main__":
    die_with_parent(int(sys.argv[1]))
    os.environ[shader_reload.VARIABLE] = "1"  # for `rebuild_used`
    build_programs(pickle.load(sys.stdin.buffer))
