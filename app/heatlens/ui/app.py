"""The program behind the window: shot, view and plate, and what can be done with them.

It knows no window and draws nothing: `Screen` does. Every picture comes from the renderer that
`heatlens render` uses.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import moderngl

from heatlens.camera.samples import CameraSamples
from heatlens.display.screen_pictures import ScreenPictures
from heatlens.errors import FaultError, HeatlensError
from heatlens.faults import faults_told
from heatlens.gpu.context import is_software
from heatlens.model.depth_histogram import DepthHistogram
from heatlens.model.lens import Lens
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.model.view import ViewState
from heatlens.model.view_geometry import PictureShape
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.plate import Plate
from heatlens.plate.start_lens import StartLens
from heatlens.render import FrameRenderer
from heatlens.session.color_choice import ColorChoice
from heatlens.session.compare_sides import CompareSides
from heatlens.session.editing import Editing
from heatlens.session.open_source import OpenSource
from heatlens.session.preferences import Preferences
from heatlens.session.reference import Reference, ReferenceLoader
from heatlens.session.render_scheduler import RenderScheduler
from heatlens.source.kind import NO_FILES
from heatlens.source.stream_source import StreamSource
from heatlens.ui.action_list import actions
from heatlens.ui.files.filing import Filing
from heatlens.ui.files.shot_documents import ShotDocuments
from heatlens.ui.palette import Palette
from heatlens.ui.panel_names import PANELS
from heatlens.ui.panels.scene_commands import SceneCommands
from heatlens.ui.panels.speed_panel import Speed
from heatlens.ui.picture.budget import budget_s
from heatlens.ui.picture.viewport import ViewportPanel
from heatlens.ui.picture_turns import PictureTurns
from heatlens.ui.start.beginning import begin
from heatlens.ui.start.first_choice import FirstChoice
from heatlens.ui.timeline.rendered_pull import RenderedPull
from heatlens.ui.timeline.timeline import Timeline
from heatlens.ui.widgets import window_words

_MESSAGE_S = 12.0


@dataclass(frozen=True)
class Start:
    """How the program begins."""

    source: str  # file, pattern, folder, scene or shot, or the name of `stream`; "": to be chosen
    plate_options: PlateOptions = field(default_factory=PlateOptions)
    lens: Mapping[str, float] = field(default_factory=dict)  # fields of Lens that are given
    defocus: DefocusSettings = field(default_factory=DefocusSettings)
    view: ViewState = field(default_factory=ViewState)
    ocio: str | None = None
    stream: StreamSource | None = None  # closed with the program
    camera: CameraSamples | None = None  # tells what of the lens `lens` does not


class App:
    """Holds what is looked at and what can be done with it; panels and loops call it."""

    def __init__(
        self,
        ctx: moderngl.Context,
        start: Start,
        wake: Callable[[], None] = lambda: None,
        preferences: Preferences | None = None,
        frames_folder: Path | None = None,
    ) -> None:
        """`wake`, called from threads, makes whoever draws draw again. Rendered frames are kept in
        `frames_folder`, None: in memory alone."""
        self.ctx = ctx
        self.start = start
        self.message = ""
        self._message_at = 0.0
        self.renderer = FrameRenderer(ctx)
        self.sides = CompareSides(self.renderer)
        self.live = self.sides.a
        self.screen = ScreenPictures(ctx)
        self.source = OpenSource(self.renderer, wake, start.stream)
        self.references = ReferenceLoader(ctx, wake)
        self.scheduler = RenderScheduler(self.source, self.sides)
        self.color = ColorChoice(start.ocio, self.say)
        self.filing = Filing(self, preferences or Preferences(), wake)
        self.view = self.color.with_names(self.filing.first_view(start.view))
        self.editing = Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0), start.defocus), self.say)
        self.begun: StartLens | None = None
        self.viewport = ViewportPanel(ctx)
        self.palette = Palette()
        self.actions = actions()
        self.timeline = Timeline(self, wake)
        self.pull = RenderedPull(self, frames_folder, wake)
        self.turns = PictureTurns(self)
        self.documents = ShotDocuments(self, wake)
        self.scenes = SceneCommands(self)
        self.panels = dict.fromkeys(PANELS, True)
        self.speed = Speed()
        self.shows_keys = False
        self.wants_layout = True
        self.is_over = False
        self._is_software = is_software(ctx)
        self.first = FirstChoice(self)
        self.filing.begin(start.source, start.plate_options)

    # What is in hand

    @property
    def shot(self) -> Shot:
        """The shot as it is seen."""
        return self.editing.shot

    @property
    def lens(self) -> Lens:
        """Its lens at the frame."""
        return self.editing.lens

    @property
    def frame(self) -> int:
        """Where the playhead is."""
        return self.editing.frame

    @property
    def has_scene(self) -> bool:
        """A 3D scene is open, which can be seen from more points than one."""
        return self.renderer.scene is not None

    @property
    def histogram(self) -> DepthHistogram | None:
        """Of the plate's distances; None where it has none."""
        return self.source.histogram

    @property
    def reference(self) -> Reference | None:
        """The EXR loaded as B."""
        return self.references.current

    @property
    def budget_s(self) -> float:
        """Time for a picture while something is dragged."""
        return budget_s(self._is_software, self.speed.window_s)

    @property
    def picture_shape(self) -> PictureShape:
        """Of the display window; one pixel while nothing is open."""
        plate = self.source.plate
        if plate is None:
            return PictureShape(1, 1)
        _, window = self.source.windows(self.shot)
        return PictureShape(window.width, window.height, plate.pixel_aspect_ratio)

    # What can be done

    def say(self, sentence: str) -> None:
        """Show a sentence in the status bar for a while."""
        self.message, self._message_at = window_words(sentence), time.perf_counter()

    def say_error(self, error: HeatlensError) -> None:
        """Show what went wrong; after a fault of the program the work in hand is kept first."""
        if isinstance(error, FaultError):
            self.documents.keep_now()
        self.say(str(error))

    def open(self, text: str, options: PlateOptions | None = None) -> None:
        """Open a file, a pattern, a folder or a shot; what is open stays until it has a picture."""
        if not self.documents.opens(text):
            self.source.open(text, options or self.filing.options_for(text))

    def reload(self) -> None:
        """Read the plate again as it is on disk now."""
        opened = self.source.opened
        if opened is not None and opened.source.is_repeatable:
            self.source.open(opened.text, opened.options, self.editing.frame)
        elif opened is not None:
            self.say(NO_FILES)

    def browse(self, purpose: str) -> None:
        """Choose a file to open, to compare with, or to save."""
        self.filing.browse(purpose)

    def copy_picture(self) -> None:
        """Put the picture on the clipboard."""
        self.filing.copy()

    def focus_at(self, pixel: tuple[int, int]) -> None:
        """Focus on what is seen at a pixel of the display window; beside the picture, nothing."""
        plate, pixel = self.source.plate, self.source.plate_px(self.shot, pixel)
        if plate is None or not _is_inside(plate, pixel):
            return
        try:
            distance_m = depth_at_m(plate, *pixel)
            self.edit_lens(replace(self.lens, focus_distance_m=distance_m))
        except HeatlensError as error:
            self.say(str(error))

    def edit(self, shot: Shot) -> None:
        """Change the shot."""
        self.editing.edit(shot)

    def edit_lens(self, lens: Lens) -> None:
        """Change the lens at the frame."""
        self.editing.edit_lens(lens)

    def reset_lens(self) -> None:
        """The lens as the plate's header, or whoever started the program, gave it."""
        if self.begun is not None:
            self.edit_lens(self.begun.lens)

    def undo(self) -> None:
        """One step back."""
        self.editing.undo()

    def redo(self) -> None:
        """One step forward."""
        self.editing.redo()

    def quit(self) -> None:
        """End the program after this frame."""
        self.is_over = True

    def reset_layout(self) -> None:
        """Panels where they were in the beginning."""
        self.panels = dict.fromkeys(self.panels, True)
        self.wants_layout = True

    def open_palette(self) -> None:
        """Find a command by its name."""
        self.palette.open()

    def toggle_keys(self) -> None:
        """The list of keys."""
        self.shows_keys = not self.shows_keys

    # What happens by itself

    def poll(self) -> None:
        """Take what threads have read; errors are said, and the last good picture stays."""
        try:
            with faults_told("What was read could not be shown"):
                self._take_news()
        except HeatlensError as error:
            self.say_error(error)
            self.first.refused()
        if self.source.plate is None:
            self.sides.restart()  # what was under way read from the plate that left the GPU
        if self.message and time.perf_counter() - self._message_at > _MESSAGE_S:
            self.message = ""

    def _take_news(self) -> None:
        opened = self.source.arrived()
        if opened is not None:
            self.pull.begin()
            begin(self, opened)
        if self.references.poll():
            self.say(f"B is {self.reference.path.name}." if self.reference else "")
        self.filing.poll()
        self.documents.poll()
        self.timeline.poll()
        self.pull.poll()

    def work(self) -> None:
        """Go on for a moment with the whole picture, else with the frames of the pull."""
        self.turns.work()

    @property
    def wants_frames(self) -> bool:
        """A gesture waits to become a step, or a shot to be saved: frames of the window do it."""
        return self.editing.is_unsettled or self.documents.is_behind

    def seconds_until_needed(self) -> float | None:
        """How long the loop may sleep without an event; None: until there is one."""
        waits: list[float | None] = [0.1] if self.wants_frames else []
        waits += [_MESSAGE_S] if self.message else []
        waits += [self.turns.seconds_until_needed(), self.timeline.seconds_until_needed()]
        return min((wait for wait in waits if wait is not None), default=None)

    def close(self) -> None:
        """End threads; the GPU's things go with its context."""
        self.filing.close()
        self.documents.close()
        self.pull.close()
        self.source.close()


def _is_inside(plate: Plate, pixel: tuple[int, int]) -> bool:
    """Whether the plate has a pixel of the display window."""
    window = plate.display_window
    return plate.data_window.contains(pixel[0] + window.x0, pixel[1] + window.y0)
