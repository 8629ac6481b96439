"""A shot of a 3D scene from options, without looking at it: `export` and `shot new` begin so."""

import argparse
from collections.abc import Collection
from dataclasses import replace

from heatlens.commands.scene_options import size_of
from heatlens.errors import InputError
from heatlens.model.filmback import filmback_named
from heatlens.model.framing import Framing
from heatlens.model.lens import Lens
from heatlens.model.shot import LensParameter, Shot
from heatlens.model.units import parse_distance_m
from heatlens.scene.scene import Scene
from heatlens.scene.scene_bounds import camera_lens, started_framing
from heatlens.scene.scene_source import is_demo, open_scene

_PARAMETERS = frozenset(map(str, LensParameter))
# The angle of view where no camera of the scene tells one; f-stop and focus have to be given.
_ASSUMED = Lens(35.0, 2.0, 5.0, 36.0)


def add_framing_options(parser: argparse.ArgumentParser, *short_names: str) -> None:
    """--size, and --scene-camera, which may have other names where these mean nothing else."""
    group = parser.add_argument_group("3D scene", "How it is looked at; plates do not ask.")
    group.add_argument(
        "--size", type=size_of, metavar="WxH", help="of the picture (default 1280x720)"
    )
    group.add_argument(
        *short_names,
        "--scene-camera",
        dest="scene_camera",
        metavar="NAME",
        help="camera of the scene to look through (default: its first; without one, all is seen)",
    )


def shot_of_scene(args: argparse.Namespace, text: str) -> tuple[Shot, Scene]:
    """The shot that options for lens and framing make of the scene called `text`.

    Values that are not given are those of the scene's camera; the program's own scene comes with
    all of them. Raises InputError where the scene cannot be read, has no such camera, or the lens
    lacks a value.
    """
    scene, given = open_scene(text), _given_lens(args)
    if is_demo(text):
        from heatlens.scene.demo.demo import demo_shot

        shot = demo_shot()
    else:
        _check_told(text, given)
        shot = Shot(
            _ASSUMED,
            source=text,
            frames=scene.frames,
            frames_per_second=scene.frames_per_second,
            framing=started_framing(scene),
        )
    shot = with_framing(args, shot)
    framing = shot.framing or Framing()
    if not is_demo(text) or args.scene_camera is not None:
        shot = replace(shot, lens=camera_lens(scene, framing, shot.lens))
    return _with_lens(shot, given), scene


def with_framing(args: argparse.Namespace, shot: Shot) -> Shot:
    """The shot with the size and the camera that were given."""
    framing = shot.framing or Framing()
    if args.size is not None:
        framing = replace(framing, width_px=args.size[0], height_px=args.size[1])
    if args.scene_camera is not None:
        framing = replace(framing, camera=args.scene_camera, track=None)
    return replace(shot, framing=framing)


def said_of_lens(shot: Shot, frame: int) -> str:
    """The lens at a frame in words."""
    lens = shot.lens_at(frame)
    return (
        f"lens at frame {frame}: focal length {lens.focal_length_mm:g} mm, sensor width "
        f"{lens.sensor_width_mm:g} mm, f/{lens.f_stop:g}, focus {lens.focus_distance_m:.4g} m"
    )


def _given_lens(args: argparse.Namespace) -> dict[str, float]:
    """Fields of Lens that the options give."""
    if args.focus_at is not None:
        raise InputError(
            "--focus-at needs a picture to look at, and a scene has none before it is rendered: "
            "give --focus-distance."
        )
    width_mm, focus = args.sensor_width, args.focus_distance
    values = {
        "focal_length_mm": args.focal_length,
        "sensor_width_mm": filmback_named(args.filmback).width_mm if args.filmback else width_mm,
        "f_stop": args.f_stop,
        "focus_distance_m": None if focus is None else parse_distance_m(focus),
        "squeeze": None if args.squeeze == 1.0 else args.squeeze,
    }
    return {name: value for name, value in values.items() if value is not None}


def _check_told(text: str, told: Collection[str]) -> None:
    """No file of a scene tells the opening of a lens, nor its focus."""
    needed = {"f_stop": "--f-stop", "focus_distance_m": "--focus-distance"}
    missing = [option for name, option in needed.items() if name not in told]
    if missing:
        options = " and ".join(missing)
        raise InputError(f"{text}: a scene does not tell all of a lens; give {options}.")


def _with_lens(shot: Shot, given: dict[str, float]) -> Shot:
    """Values that are given hold at every frame, whatever keys there were."""
    for name in _PARAMETERS & set(given):
        curve = shot.curves.of(LensParameter(name))
        shot = shot.with_curve(LensParameter(name), replace(curve, keys=()))
    return replace(shot, lens=replace(shot.lens, **given))
