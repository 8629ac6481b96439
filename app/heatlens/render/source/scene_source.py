"""A 3D scene as a source, and as it is opened: every frame exists, and is drawn on request."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import absolute, unreadable_error
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.live_focus import Distances
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, ObjectMark
from heatlens.core.model.shot.framing import Framing, SceneTiming
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.header.header_lens import StartLens
from heatlens.media.scene.first_shot import FirstShot, first_shot, lens_with_fields
from heatlens.media.scene.placing import place_scene
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import object_depth_m, object_names, track_of
from heatlens.media.scene.scene_read import files_of_scene, is_demo, open_scene
from heatlens.media.sequence.sequence import MissingPolicy, Stamp, stamp_files
from heatlens.render.source.opened import Opened, Opening
from heatlens.render.source.source import FrameLoader, Origin, Renderer

_STILL_FRAME = 1  # the frame of a scene in which nothing moves


@dataclass(frozen=True)
class SceneSource:
    """The scene called `text`, which is read on first use. Implements `Source`.

    `timing` converts its seconds to frames; None uses the default.
    """

    text: str
    timing: SceneTiming | None = None

    first_file: ClassVar = None
    has_many_views: ClassVar = True

    @property
    def files(self) -> Path | None:
        return None if is_demo(self.text) else Path(self.text)

    @cached_property
    def scene(self) -> Scene:
        """The scene itself. Raises InputError if it cannot be read."""
        return open_scene(self.text, self.timing)

    @property
    def frames(self) -> FrameRange | None:
        """The frames in which something moves; None if nothing does."""
        return self.scene.frames

    def with_absolute_paths(self) -> "SceneSource":
        return SceneSource(self.text if self.files is None else absolute(self.text), self.timing)

    def require(self) -> None:
        if self.files is not None and not os.path.isfile(self.files):
            raise unreadable_error(self.files)

    def span(self, shot: Shot) -> FrameRange | None:
        """See `Source`; the frames of the shot, else those in which something moves."""
        return shot.frames or self.scene.frames

    def frames_of(self, shot: Shot) -> tuple[int, ...]:
        """See `Source`; without an in and out point, the frames in which something moves."""
        return tuple(shot.played_frames or self.scene.frames or (_STILL_FRAME,))

    def check(self, shot: Shot, frames: tuple[int, ...], missing: MissingPolicy) -> None:
        """Raise InputError if the file is missing; a scene has every frame."""
        self.require()

    def origin(self, shot: Shot, frame: int, missing: MissingPolicy) -> Origin:
        """See `Source`; every frame is made of all files of the scene."""
        return Origin(frame, files=stamp_files(self.all_files))

    def distances_m(
        self, shot: Shot, mark: Mark, report_progress: Callable[[str], None]
    ) -> Distances:
        """See `Source`; objects and distances need no picture of the scene. Raises InputError."""
        framing, scene = shot.framing or Framing(), place_scene(self.scene, shot.framing)
        frames = shot.frames or self.scene.frames or FrameRange(_STILL_FRAME, _STILL_FRAME)
        if isinstance(mark, DistanceMark):
            return dict.fromkeys(frames, mark.distance_m)
        if not isinstance(mark, ObjectMark):
            raise InputError(
                f"Mark {mark.name}: in a scene, name an object to follow, as in "
                f"{mark.name}=object:{object_names(scene)[0]}."
            )
        distances_m = {}
        for frame in frames:
            pose = track_of(scene, framing, shot.lens_at(frame)).pose_at(frame)
            distances_m[frame] = object_depth_m(scene, mark.object_name, pose, frame)
        return distances_m

    @cached_property
    def all_files(self) -> tuple[Path, ...]:
        """The scene's file and those that it names, whether they exist or not.

        Raises InputError if a file that names others cannot be read.
        """
        return () if self.files is None else files_of_scene(self.files)

    def loader(
        self, shot: Shot, origins: tuple[Origin, ...], renderer: Renderer, is_for_file: bool = False
    ) -> FrameLoader:
        """See `Source`; the scene is uploaded to the GPU once for all frames."""
        renderer.load_scene(place_scene(self.scene, shot.framing))
        return _SceneLoader(shot, renderer, is_for_file)


@dataclass(frozen=True)
class _SceneLoader:
    """Draws the pinhole picture of each frame of a scene. See `FrameLoader`."""

    shot: Shot
    renderer: Renderer
    is_for_file: bool

    def load(self, origin: Origin) -> None:
        self.renderer.load_pinhole(self.shot, origin.frame, is_for_file=self.is_for_file)

    def close(self) -> None:
        """Do nothing, because nothing is read ahead."""


def make_scene_source(text: str, _options: PlateOptions, timing: SceneTiming | None) -> SceneSource:
    """Return the scene called `text`, which is not opened before it is needed."""
    return SceneSource(text, timing)


def make_single_scene_source(path: Path, _options: PlateOptions) -> SceneSource:
    """Return the scene in a file."""
    return SceneSource(str(path))


@dataclass(frozen=True, eq=False)
class OpenedScene(Opened):
    """A 3D scene with its first shot; `requested_options` are unused, as a scene has no plates."""

    text: str
    frame: int
    notes: tuple[str, ...]
    scene: Scene = field()
    timing: SceneTiming | None = field()
    stamps: tuple[Stamp | None, ...] = field()
    render_source: SceneSource = field()
    requested_options: PlateOptions
    first: FirstShot

    @property
    def options(self) -> PlateOptions:
        """The requested options; a scene has no plates."""
        return self.requested_options

    @property
    def frames(self) -> FrameRange | None:
        """The frames in which something moves."""
        return self.scene.frames

    def lens(self, lens_fields: Mapping[str, object]) -> StartLens:
        """Return the given lens, completed from the scene's camera, or assumed."""
        return StartLens(
            lens_with_fields(self.first, lens_fields), dict.fromkeys(lens_fields, "given")
        )

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """Return the first shot; a given value replaces the keys of the scene's camera."""
        shot = replace(self.first.shot, lens=lens, defocus=defocus)
        for parameter in LensParameter:
            if getattr(lens, parameter) != getattr(self.first.shot.lens, parameter):
                curve = shot.curves.of(parameter)
                shot = shot.with_curve(parameter, replace(curve, keys=()))
        return shot


def open_scene_source(opening: Opening) -> OpenedScene:
    """Read a scene; `opening.placing` gives the unit and the up axis if its file does not.

    Raises InputError with the name of the file if it cannot be read.
    """
    source = SceneSource(opening.text, opening.timing)
    stamps = tuple(file.stamp for file in stamp_files(source.all_files))  # before it is read
    with opening.stop.applies_to_thread():
        first = first_shot(opening.text, timing=opening.timing, placing=opening.placing)
    return OpenedScene(
        text=opening.text,
        frame=first.frame,
        notes=first.scene.notes,
        scene=first.scene,
        timing=opening.timing,
        stamps=stamps,
        render_source=source,
        requested_options=opening.options,
        first=first,
    )
