"""The options that say how a 3D scene is looked at."""

import argparse
import re
from dataclasses import replace

from heatlens.commands.lens_options import lens_of
from heatlens.errors import InputError
from heatlens.image.plate import CameraHeader, Plate
from heatlens.model.filmback import filmback_named
from heatlens.model.framing import Framing
from heatlens.model.lens import Lens
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer
from heatlens.scene.scene import Scene
from heatlens.scene.scene_bounds import started_framing
from heatlens.scene.scene_source import is_demo, open_scene

_FULL_FRAME_MM = 36.0
_FOCAL_MM = 35.0  # where no camera tells


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """--size, --camera, --frame."""
    group = parser.add_argument_group("3D scene", "How it is looked at; plates do not ask.")
    group.add_argument(
        "--size", type=size_of, metavar="WxH", help="of the picture (default 1280x720)"
    )
    group.add_argument(
        "--camera",
        metavar="NAME",
        help="camera of the scene to look through (default: its first; without one, all is seen)",
    )
    group.add_argument("--frame", type=int, metavar="N", help="of the animation (default: first)")


def size_of(text: str) -> tuple[int, int]:
    """WxH; argparse turns the error into its own sentence."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if min(size) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no size in pixels, such as 1920x1080")
    return size


def framing_of(args: argparse.Namespace, scene: Scene) -> Framing:
    """What of `scene` the options ask for. Raises InputError for a camera that it does not have."""
    framing = started_framing(scene, args.size)
    if args.camera is not None:
        framing = replace(framing, camera=scene.camera_named(args.camera).name)
    return framing


def load_scene(
    args: argparse.Namespace, renderer: FrameRenderer, defocus: DefocusSettings
) -> tuple[Shot, int, list[str]]:
    """Have the renderer look at the scene that `args.plate` names.

    The shot, the frame, and a sentence on each value of its lens. Raises InputError where the scene
    cannot be read, or no lens be made of the options.
    """
    scene = open_scene(str(args.plate))
    framing = framing_of(args, scene)
    frame = args.frame if args.frame is not None else scene.frames.first if scene.frames else 1
    renderer.load_scene(scene)
    told = _told(args, scene, framing, frame)
    focal_mm = told.focal_length_mm or _FOCAL_MM
    width_mm = told.sensor_width_mm or _FULL_FRAME_MM
    pinhole = Shot(Lens(focal_mm, 22.0, float("inf"), width_mm), framing=framing)
    plate: Plate = replace(renderer.look(pinhole, frame).plate, camera=told)
    lens, said = lens_of(args, plate)
    return Shot(lens, defocus, source=str(args.plate), framing=framing), frame, said


def _told(args: argparse.Namespace, scene: Scene, framing: Framing, frame: int) -> CameraHeader:
    """What the options and the scene tell of the lens; the demo comes with a whole shot."""
    told: dict[str, float] = {"focal_length_mm": _FOCAL_MM, "sensor_width_mm": _FULL_FRAME_MM}
    if framing.camera is not None:
        camera = scene.camera_named(framing.camera)
        told = {
            "focal_length_mm": camera.focal_length_mm,
            "sensor_width_mm": camera.sensor_width_mm,
        }
    if is_demo(str(args.plate)):
        from heatlens.scene.demo.demo import demo_shot

        lens = demo_shot().lens_at(frame)
        told |= {"f_stop": lens.f_stop, "focus_distance_m": lens.focus_distance_m}
    where = dict.fromkeys(told, "the scene's camera" if framing.camera else "assumed")
    if args.focal_length is not None:
        told["focal_length_mm"] = args.focal_length
    if args.filmback is not None:
        told["sensor_width_mm"] = filmback_named(args.filmback).width_mm
    elif args.sensor_width is not None:
        told["sensor_width_mm"] = args.sensor_width
    return CameraHeader(**told, sources=where)


def check_no_scene_options(args: argparse.Namespace) -> None:
    """A plate is as large as it is, and seen from where it was made."""
    for name in ("size", "camera", "frame"):
        if getattr(args, name) is not None:
            raise InputError(f"{args.plate} is a plate: --{name} is for 3D scenes.")
