"""`heatlens shot size`: keep the size of a thing while focal length or camera change."""

import argparse
from functools import cache
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.fronts.commands.options.value_types import number
from heatlens.fronts.commands.output.say import say, tell
from heatlens.media.documents.shot_file import SHOT_SUFFIX, read_shot, write_shot
from heatlens.media.scene.placing import placed
from heatlens.media.scene.same_size import KeptSize, crop_words
from heatlens.media.scene.scene_read import open_scene
from heatlens.render.frame_renderer import FrameRenderer, headless_renderer
from heatlens.render.source.named import has_camera

HELP = "keep the size of what is on a mark, by the camera or by the focal length"
DESCRIPTION = """\
Writes a shot in which the thing on a mark is as large as in another. With --focal-length the
camera of the scene goes along its axis until it is; focus, keys and marks follow. --by makes a
dolly zoom of a shot that has keys.
"""
EPILOG = """\
examples:
  heatlens shot size wide.heatlens.json A -o long.heatlens.json --focal-length 85
  heatlens shot size zoom.heatlens.json A -o dolly.heatlens.json --by camera
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shot", type=Path, metavar="SHOT.heatlens.json", help="the shot of a scene")
    parser.add_argument("mark", metavar="MARK", help="name of the mark whose thing keeps its size")
    parser.add_argument("-o", "--output", type=Path, required=True, help=f"*{SHOT_SUFFIX} to write")
    how = parser.add_mutually_exclusive_group(required=True)
    how.add_argument("--focal-length", type=number, metavar="MM", help="the other focal length")
    how.add_argument(
        "--by",
        choices=("camera", "length"),
        help="camera: it moves as the keys of the focal length ask for; length: the focal length "
        "gets keys that go with the moving camera",
    )
    parser.add_argument(
        "--frame", type=int, metavar="N", help="where the size is measured (default: the first)"
    )


def run(args: argparse.Namespace) -> int:
    """Write the shot; print where the thing is."""
    if not args.output.name.endswith(SHOT_SUFFIX):
        raise InputError(f"{args.output}: the name of a shot file must end in {SHOT_SUFFIX}.")
    shot = read_shot(args.shot)
    if shot.mark_named(args.mark) is None:
        names = ", ".join(mark.name for mark in shot.marks) or "none"
        raise InputError(f"{args.shot} has no mark {args.mark!r}; its marks: {names}.")
    frame = args.frame if args.frame is not None else shot.span.first if shot.span else 1
    if not has_camera(shot.source):
        length_mm = args.focal_length or shot.lens_at(frame).focal_length_mm
        raise InputError(f"{args.shot}: {crop_words(shot, frame, length_mm)}")
    kept = _kept(shot, frame, args.mark)
    made = _made(kept, args)
    write_shot(args.output, made)
    before_m, after = kept.depth_m(frame), _kept(made, frame, args.mark)
    say(
        f"{args.mark} is at {format_distance(after.depth_m(frame))} with "
        f"{made.lens_at(frame).focal_length_mm:.4g} mm at frame {frame}; it was at "
        f"{format_distance(before_m)} with {shot.lens_at(frame).focal_length_mm:.4g} mm."
    )
    tell(str(args.output))
    return 0


def _made(kept: KeptSize, args: argparse.Namespace) -> Shot:
    if args.focal_length is not None:
        return kept.at_length(args.focal_length)
    return kept.by_camera() if args.by == "camera" else kept.by_length()


def _kept(shot: Shot, frame: int, name: str) -> KeptSize:
    framing = shot.framing or Framing()
    scene = placed(open_scene(str(shot.source), framing.timing), framing)
    mark = shot.mark_named(name)
    assert mark is not None

    @cache
    def renderer() -> FrameRenderer:
        made = headless_renderer()
        made.load_scene(scene)
        return made

    return KeptSize(
        scene, shot, frame, mark, lambda x, y: renderer().scene_depth_m(shot, frame, x, y)
    )
