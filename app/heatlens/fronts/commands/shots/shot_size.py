"""`heatlens shot size`: keep the size of an object while focal length or camera change."""

import argparse
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.fronts.commands.options.value_types import parse_number
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.media.documents.shot_file import SHOT_SUFFIX, read_shot, write_shot
from heatlens.media.scene.placing import place_scene
from heatlens.media.scene.same_size import KeptSize, crop_words
from heatlens.media.scene.scene_read import open_scene
from heatlens.render.source.named import has_camera

if TYPE_CHECKING:  # the other actions on shots draw nothing
    from heatlens.render.frame_renderer import FrameRenderer

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
    methods = parser.add_mutually_exclusive_group(required=True)
    methods.add_argument(
        "--focal-length", type=parse_number, metavar="MM", help="the other focal length"
    )
    methods.add_argument(
        "--by",
        choices=("camera", "length"),
        help="camera: it moves as the keys of the focal length ask for; length: the focal length "
        "gets keys that go with the moving camera",
    )
    parser.add_argument(
        "--frame", type=int, metavar="N", help="where the size is measured (default: the first)"
    )


def run(args: argparse.Namespace) -> int:
    """Write the shot; print the old and the new distance of the object on the mark."""
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
    kept_size = _kept_size(shot, frame, args.mark)
    new_shot = _make_shot(kept_size, args)
    write_shot(args.output, new_shot)
    before_m, new_size = kept_size.depth_m(frame), _kept_size(new_shot, frame, args.mark)
    print_messages(
        f"{args.mark} is at {format_distance(new_size.depth_m(frame))} with "
        f"{new_shot.lens_at(frame).focal_length_mm:.4g} mm at frame {frame}; it was at "
        f"{format_distance(before_m)} with {shot.lens_at(frame).focal_length_mm:.4g} mm."
    )
    print_result(str(args.output))
    return 0


def _make_shot(kept_size: KeptSize, args: argparse.Namespace) -> Shot:
    """Return the shot that keeps the size, by another focal length, the camera or its keys."""
    if args.focal_length is not None:
        return kept_size.with_focal_length(args.focal_length)
    return (
        kept_size.follow_with_camera()
        if args.by == "camera"
        else kept_size.follow_with_focal_length()
    )


def _kept_size(shot: Shot, frame: int, name: str) -> KeptSize:
    """Return the size of what is on the mark `name` at a frame, to be kept in other shots."""
    framing = shot.framing or Framing()
    scene = place_scene(open_scene(str(shot.source), framing.timing), framing)
    mark = shot.mark_named(name)
    assert mark is not None

    @cache
    def renderer() -> "FrameRenderer":
        from heatlens.render.frame_renderer import headless_renderer

        renderer_of_scene = headless_renderer()
        renderer_of_scene.load_scene(scene)
        return renderer_of_scene

    return KeptSize(
        scene, shot, frame, mark, lambda x, y: renderer().scene_depth_m(shot, frame, x, y)
    )
