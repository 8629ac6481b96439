"""3D scenes on the command line."""

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import join_first_names
from heatlens.core.model.curves.frames import parse_frame_range
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.options.given_options import refuse_options, refuse_unused_options
from heatlens.fronts.commands.options.scene_options import (
    given_placing,
    lens_message,
    load_scene,
    shot_of_scene,
)
from heatlens.fronts.commands.output.plate_words import print_breathing
from heatlens.fronts.commands.output.say import print_messages
from heatlens.fronts.commands.sources.shot_plate import shot_rate
from heatlens.fronts.commands.sources.source_commands import Facts, Line, SourceCommands
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.scene.first_shot import FirstShot, first_shot
from heatlens.media.scene.scene import Scene, SceneCamera
from heatlens.media.scene.scene_bounds import bounds_m, object_names
from heatlens.media.sequence.names import parse_frames

if TYPE_CHECKING:
    from heatlens.render.frame_renderer import FrameRenderer  # `info` draws nothing


def _object_needed_error(scene: Scene, mark: Mark) -> InputError:
    return InputError(
        f"Mark {mark.name}: in a scene, name an object to follow, as in "
        f"{mark.name}=object:{object_names(scene)[0]}."
    )


class SceneCommands(SourceCommands):
    """Reads scenes, whose cameras have the lens and may move."""

    def load(
        self, args: argparse.Namespace, renderer: "FrameRenderer", settings: DefocusSettings
    ) -> tuple[Shot, int]:
        """Load the scene, and return the shot of its camera and the frame, and print messages."""
        shot, frame, notes = load_scene(args, renderer, settings)
        print_messages(*notes)
        print_breathing(shot.lens, plate=None)
        return shot, frame

    def shot(self, args: argparse.Namespace) -> Shot:
        """Return a shot with the lens of the options and of the scene's moving camera."""
        first = shot_of_scene(args, args.shot)
        given_frames = getattr(args, "frames", None)
        frame = parse_frames(given_frames)[0] if given_frames else first.frame
        print_messages(*first.scene.notes, lens_message(args, first, frame))
        return first.shot

    def new_shot(self, args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
        """Return a shot with the lens, frames, rate and framing of the scene's camera."""
        first = shot_of_scene(args, args.plate)
        shot = first.shot
        print_messages(*first.scene.notes)
        camera_frames = None if camera is None else camera.frame_range
        frames = parse_frame_range(args.frames) if args.frames else camera_frames or shot.frames
        is_own = args.fps is None and camera is None
        rate = shot.frames_per_second if is_own else shot_rate(args, camera)
        return replace(shot, frames=frames, frames_per_second=rate)

    def track_mark(self, args: argparse.Namespace, shot: Shot, mark: TrackMark) -> TrackMark:
        """Raise InputError: a scene has the positions of its objects, which need no tracking."""
        raise _object_needed_error(shot_of_scene(args, args.plate).scene, mark)

    def info(self, args: argparse.Namespace, text: str) -> tuple[Facts, list[Line]]:
        """Return the cameras, frames, objects, triangles, lights and size of the scene."""
        refuse_unused_options(args, text)
        lens = ("focal_length", "sensor_width")
        refuse_options(args, lens, f"{text} is a 3D scene, but this option is for depth along rays")
        facts = scene_facts(first_shot(text, placing=given_placing(args)))
        return facts, scene_lines(facts)


def scene_facts(first: FirstShot) -> Facts:
    """Return cameras, frames, objects and the size of the scene at the first frame.

    Lengths are meters or millimeters as their names say; x is to the right, y up. `frames` is None
    for a still scene.
    """
    scene, frames = first.scene, first.shot.frames
    low, high = bounds_m(scene, first.frame)
    return {
        "path": str(scene.path),
        "frames": None if frames is None else {"first": frames.first, "last": frames.last},
        "frames_per_second": first.shot.frames_per_second,
        "clips": list(scene.clips),
        "cameras": [_camera_facts(camera) for camera in scene.cameras],
        "lens_model": str(first.shot.lens.model),
        "objects": list(object_names(scene)),
        "triangles": scene.triangle_count,
        "lights": len(scene.lights),
        "sun": any(scene.daylight.sun),
        "size_m": [float(side) for side in high - low],
        "low_m": [float(value) for value in low],
        "notes": list(scene.notes),
    }


def _camera_facts(camera: SceneCamera) -> Facts:
    """Return what `info --json` tells about a camera of the scene."""
    return {
        "name": camera.name,
        "focal_length_mm": camera.focal_length_mm,
        "sensor_width_mm": camera.sensor_width_mm,
        "sensor_width_assumed": camera.is_width_assumed,
        "moves": camera.track.is_moving,
    }


def scene_lines(facts: Facts) -> list[Line]:
    """Return the facts of `scene_facts` as text, each with a label."""
    return [
        ("scene", facts["path"]),
        ("frames", _frames_line(facts)),
        *([("clips", ", ".join(facts["clips"]))] if len(facts["clips"]) > 1 else []),
        *_camera_lines(facts["cameras"]),
        ("lens model", facts["lens_model"]),
        ("objects", _objects_text(facts["objects"])),
        ("triangles", f"{facts['triangles']:,}"),
        ("lights", _lights_text(facts)),
        ("size", " x ".join(f"{side:.4g}" for side in facts["size_m"]) + " m, y up"),
        *(("note", note) for note in facts["notes"]),
    ]


def _frames_line(facts: Facts) -> str:
    frames = facts["frames"]
    if frames is None:
        return "nothing moves"
    return f"{frames['first']} to {frames['last']}, {facts['frames_per_second']:g} per second"


def _camera_lines(cameras: list[Facts]) -> list[Line]:
    """Return a line for each camera; the first is used unless another is named."""
    lines = [
        (
            "camera",
            f"{camera['name']}, focal length {camera['focal_length_mm']:.4g} mm, sensor width "
            f"{camera['sensor_width_mm']:.4g} mm{_camera_details(camera)}",
        )
        for camera in cameras
    ]
    return lines or [("camera", "none: the view shows the whole scene")]


def _camera_details(camera: Facts) -> str:
    """Return what the list of cameras says besides the lens: an assumed sensor, motion."""
    assumed_text = " (assumed: the file has only its angle of view)"
    moves_text = ", moves" if camera["moves"] else ""
    return (assumed_text if camera["sensor_width_assumed"] else "") + moves_text


def _objects_text(names: list[str]) -> str:
    return f"{len(names)}: {join_first_names(names)}"


def _lights_text(facts: Facts) -> str:
    lamps = {0: "", 1: "1 lamp"}.get(facts["lights"], f"{facts['lights']} lamps")
    sun = "the sun" if facts["sun"] else ""
    return (
        " and ".join(light_text for light_text in (sun, lamps) if light_text) or "none but the sky"
    )
