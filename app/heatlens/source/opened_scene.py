"""A 3D scene that has been opened, with its first shot."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from heatlens.model.curves.frames import FrameRange
from heatlens.model.lens.lens import Lens
from heatlens.model.shot.framing import SceneTiming
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.model.shot.settings import DefocusSettings
from heatlens.model.shot.shot import LensParameter, Shot
from heatlens.plate.header.header_lens import StartLens
from heatlens.scene.first_shot import FirstShot, first_shot, lens_with
from heatlens.scene.scene import Scene
from heatlens.sequence.sequence import Stamp
from heatlens.source.opened import Opened, Opening
from heatlens.source.scene_source import SceneSource
from heatlens.source.source import stamped


@dataclass(frozen=True, eq=False)
class OpenedScene(Opened):
    """A 3D scene with its first shot; `asked` are the options that its plates would have."""

    text: str
    frame: int
    notes: tuple[str, ...]
    scene: Scene = field()
    timing: SceneTiming | None = field()
    stamps: tuple[Stamp | None, ...] = field()
    again: SceneSource = field()
    asked: PlateOptions
    first: FirstShot

    @property
    def options(self) -> PlateOptions:
        """The options that were asked for; a scene has no plates."""
        return self.asked

    @property
    def frames(self) -> FrameRange | None:
        """The frames in which something moves."""
        return self.scene.frames

    def lens(self, given: Mapping[str, object]) -> StartLens:
        """Return the given lens, completed from the scene's camera, or assumed."""
        return StartLens(lens_with(self.first, given), dict.fromkeys(given, "given"))

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """Return the first shot; a given value replaces the keys of the scene's camera."""
        shot = replace(self.first.shot, lens=lens, defocus=defocus)
        for parameter in LensParameter:
            if getattr(lens, parameter) != getattr(self.first.shot.lens, parameter):
                curve = shot.curves.of(parameter)
                shot = shot.with_curve(parameter, replace(curve, keys=()))
        return shot


def opened_scene(opening: Opening) -> OpenedScene:
    """Read a scene; `opening.placing` gives the unit and the up axis if its file does not.

    Raises InputError that names the file if that fails.
    """
    source = SceneSource(opening.text, opening.timing)
    stamps = tuple(file.stamp for file in stamped(source.all_files))  # before it is read
    with opening.stop.heard():
        first = first_shot(opening.text, timing=opening.timing, placing=opening.placing)
    scene, timing = first.scene, opening.timing
    told = opening.text, first.frame, scene.notes, scene, timing, stamps
    return OpenedScene(*told, source, opening.options, first)
