"""3D scenes on the command line."""

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from heatlens.camera.samples import CameraSamples
from heatlens.commands.options.given_options import refuse_given, refuse_unused
from heatlens.commands.options.scene_options import (
    load_scene,
    placing_of,
    said_of_lens,
    shot_of_scene,
)
from heatlens.commands.output.plate_words import say_breathing
from heatlens.commands.output.say import say
from heatlens.commands.sources.info_scene import scene_lines
from heatlens.commands.sources.shot_plate import rate_of
from heatlens.commands.sources.source_commands import Line, SourceCommands
from heatlens.model.frames import parse_frame_range
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.scene.first_shot import first_shot
from heatlens.scene.scene_facts import scene_facts

if TYPE_CHECKING:
    from heatlens.render import FrameRenderer  # `info` draws nothing


class SceneCommands(SourceCommands):
    """Reads scenes, whose cameras have the lens and may move."""

    def load(
        self, args: argparse.Namespace, renderer: "FrameRenderer", settings: DefocusSettings
    ) -> tuple[Shot, int]:
        """Load the scene, and return the shot of its camera and the frame."""
        shot, frame, notes = load_scene(args, renderer, settings)
        say(*notes)
        say_breathing(shot.lens, None)
        return shot, frame

    def shot(self, args: argparse.Namespace) -> Shot:
        """Return a shot with the lens of the options and of the scene's moving camera."""
        first = shot_of_scene(args, args.shot)
        say(*first.scene.notes, said_of_lens(args, first, first.frame))
        return first.shot

    def new_shot(self, args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
        """Return a shot with the lens, frames, rate and framing of the scene's camera."""
        first = shot_of_scene(args, args.plate)
        shot = first.shot
        say(*first.scene.notes)
        camera_frames = None if camera is None else camera.frame_range
        frames = parse_frame_range(args.frames) if args.frames else camera_frames or shot.frames
        is_own = args.fps is None and camera is None
        rate = shot.frames_per_second if is_own else rate_of(args, camera)
        return replace(shot, frames=frames, frames_per_second=rate)

    def info(self, args: argparse.Namespace, text: str) -> tuple[dict[str, Any], list[Line]]:
        """Return its cameras, frames, objects, triangles, lights and size."""
        refuse_unused(args, text)
        lens = ("focal_length", "sensor_width")
        refuse_given(args, lens, f"{text} is a 3D scene, and that is for depth along rays")
        facts = scene_facts(first_shot(text, placing=placing_of(args)))
        return facts, scene_lines(facts)
