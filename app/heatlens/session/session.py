"""What the program behind the window holds: the open document and all that can be done with it.

It knows no window and draws nothing. Every picture comes from the renderer that `heatlens render`
uses.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from heatlens.errors import FaultError, HeatlensError, InputError
from heatlens.faults import faults_told
from heatlens.gpu import shader_reload
from heatlens.model.depth_histogram import DepthHistogram
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.model.view import ViewState
from heatlens.model.view_geometry import PictureShape
from heatlens.plate.timecode import timecode_of
from heatlens.preview.shown import Shown
from heatlens.render import FrameRenderer
from heatlens.session.clip_choice import ClipChoice
from heatlens.session.color_choice import ColorChoice
from heatlens.session.compare_sides import CompareSides
from heatlens.session.editing import Editing
from heatlens.session.export_commands import ExportCommands
from heatlens.session.file_commands import FileCommands
from heatlens.session.focus_track import MarkTrack, MarkTracks
from heatlens.session.frame_player import FramePlayer
from heatlens.session.key_commands import KeyCommands
from heatlens.session.key_rows import RowChoice
from heatlens.session.lens_commands import LensCommands
from heatlens.session.live_picture import LivePicture
from heatlens.session.look_commands import LookCommands
from heatlens.session.lost_surfaces import LostSurfaces
from heatlens.session.mark_commands import MarkCommands
from heatlens.session.messages import Messages, Problem
from heatlens.session.open_source import OpenSource
from heatlens.session.picture_commands import PictureCommands
from heatlens.session.picture_view import PictureView
from heatlens.session.preferences import Preferences
from heatlens.session.pull_jobs import PullJobs
from heatlens.session.pull_recording import PullRecording
from heatlens.session.recent_files import RecentFiles
from heatlens.session.reference import Reference, ReferenceLoader
from heatlens.session.render_scheduler import RenderScheduler
from heatlens.session.rendered_pull import RenderedPull, store_of
from heatlens.session.ring_hand import RingHand
from heatlens.session.ring_out import RingOut
from heatlens.session.ring_take import RingTake
from heatlens.session.scene_commands import SceneCommands
from heatlens.session.scene_mark_tracks import SceneMarkTracks
from heatlens.session.sent_lens import SentLens
from heatlens.session.shot_documents import ShotDocuments
from heatlens.session.speed import Speed
from heatlens.session.start import GivenOptions, Start
from heatlens.session.start_choices import StartChoices
from heatlens.session.start_shot import first_lens, with_given_camera
from heatlens.session.timeline import Timeline
from heatlens.session.view_commands import ViewCommands
from heatlens.source.opened import Opened

_SETTLING_S = 0.1  # until a gesture may have ended, or a shot is to be kept
_NEXT_SLICE_S = 0.005  # until marks of a scene are measured on: the window answers in between


class Session:
    """Holds the open document; panels and loops read it and call its commands."""

    def __init__(
        self,
        renderer: FrameRenderer,
        start: Start,
        wake: Callable[[], None] = lambda: None,
        preferences: Preferences | None = None,
        frames_folder: Path | None = None,
        is_software: bool = False,
    ) -> None:
        """Begin as `start` says.

        `wake`, called from threads, makes whoever draws draw again. Rendered frames are kept in
        `frames_folder`, None: in memory alone. `is_software`: the processor draws the window.
        """
        self.messages = Messages()
        say = self.messages.say
        self._lost_surfaces = LostSurfaces(say)
        self.preferences = preferences or Preferences()
        self.given = GivenOptions(start)
        self.speed = Speed(is_software=is_software)
        self.color = ColorChoice(start.ocio, say)
        self.picture_view = PictureView(
            self.color.with_names(self.preferences.first_view(start.view))
        )
        self.editing = Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0), start.defocus), say)
        self.source = OpenSource(renderer, wake, start.stream)
        self.source.opener.placing_of = self.given.placing_of
        self.references = ReferenceLoader(renderer.ctx, wake)
        self.lens_commands = LensCommands(self.source, self.editing, say)
        self.sent_lens = SentLens(self.source, self.editing, self.given, say)
        self.ring_out = RingOut(start.lens_out, self.editing, say)
        self.ring = RingHand(start.lens_in, self.editing, say, self.preferences, wake=wake)
        self.view_commands = ViewCommands(
            self.picture_view, self.source, self.editing, self.references, say
        )
        self.sides = CompareSides(renderer)
        self.looks = LookCommands(self.editing, self.picture_view, say)
        self._add_time_commands(say, wake, frames_folder)
        self._add_file_commands(say, wake)
        self._shaders = shader_reload.ShaderReload() if shader_reload.is_on() else None

    def _add_time_commands(
        self, say: Callable[[str], None], wake: Callable[[], None], frames_folder: Path | None
    ) -> None:
        """Add the timeline, keys, marks and the scene's camera, and the frames that are played."""
        source, editing, view = self.source, self.editing, self.picture_view
        now = self.preferences.now
        self.timeline = timeline = Timeline(source, editing, say)
        editing.has_time = lambda: timeline.has_time
        timeline.playback.ending, timeline.playback.is_every_frame = now.ending, now.every_frame
        self.scenes = SceneCommands(source, editing, say)
        self.clips = ClipChoice(source, editing)
        rows = RowChoice(lambda: source.has_scene)
        self.keys = KeyCommands(editing, rows, self.scenes.set_key, say)
        self.marks = MarkCommands(source, editing, timeline, self.scenes, say, wake)
        self._plate_tracks = MarkTracks()
        self.scene_tracks = SceneMarkTracks(
            source, editing, timeline, self.scenes, lambda: self._is_measuring_late
        )
        self.pull = RenderedPull(
            PullJobs(source, editing, timeline, view, wake),
            store_of(now, frames_folder, wake),
            source,
            editing,
            timeline,
            view,
            self.preferences,
            lambda: self.scene_tracks.is_due,
            wake,
        )
        self.ring.on_turn = self.pull.touched  # nothing is rendered ahead while it turns
        self.player = FramePlayer(timeline, source, editing, self.pull, say)
        self.recording = PullRecording(
            editing, timeline, rows, RingTake(self.ring, source, editing), say
        )
        self.scheduler = RenderScheduler(
            source, self.sides, self.pull, editing, view, self.speed, self.say_error
        )

    def _add_file_commands(self, say: Callable[[str], None], wake: Callable[[], None]) -> None:
        """Add documents, files and exports; open what the command line named."""
        source, editing, view = self.source, self.editing, self.picture_view
        preferences, stream = self.preferences, self.given.start.stream
        self.documents = ShotDocuments(
            source, editing, self.timeline, preferences, self.given, say, wake
        )
        self.pictures = PictureCommands(source, editing, view, self.color, self.live, say, wake)
        self.files = FileCommands(
            source,
            editing,
            self.documents,
            self.pictures,
            self.references,
            preferences,
            self.given,
            say,
            wake,
        )
        self.exports = ExportCommands(source, editing, self.timeline, view, self.color, say, wake)
        self.files.write_sheet = self.exports.write_sheet
        self.recent = RecentFiles(preferences, stream.text if stream else None, wake)
        self.start_choices = StartChoices(
            source, self.timeline.playback, self.files, self.recent, self.given
        )
        self.files.open_first()

    # What is in hand

    @property
    def renderer(self) -> FrameRenderer:
        """What renders every picture."""
        return self.source.renderer

    @property
    def live(self) -> LivePicture:
        """The picture through the lens, side A of the comparison."""
        return self.sides.a

    @property
    def view(self) -> ViewState:
        """How the picture is looked at."""
        return self.picture_view.state

    @view.setter
    def view(self, state: ViewState) -> None:
        self.picture_view.state = state

    @property
    def is_plain(self) -> bool:
        """Return True where nothing is seen but the picture through the lens."""
        return self.picture_view.is_lens_alone and not self.pull.is_alone

    @property
    def message(self) -> str:
        """What was said last, for as long as it is shown."""
        return self.messages.text

    @property
    def shot(self) -> Shot:
        """The shot as it is seen."""
        return self.editing.shot

    @property
    def lens(self) -> Lens:
        """The lens of the shot at the playhead."""
        return self.editing.lens

    @property
    def frame(self) -> int:
        """The frame of the playhead."""
        return self.editing.frame

    @property
    def has_scene(self) -> bool:
        """Return True where a 3D scene is open, which can be seen from more points than one."""
        return self.source.has_scene

    @property
    def histogram(self) -> DepthHistogram | None:
        """The plate's distances; None where it has none."""
        return self.source.histogram

    @property
    def reference(self) -> Reference | None:
        """The EXR loaded as B."""
        return self.references.current

    @property
    def picture_shape(self) -> PictureShape:
        """The shape of the display window; one pixel while nothing is open."""
        return self.source.picture_shape(self.shot)

    @property
    def seen(self) -> Shown | None:
        """The picture through the lens that is to be on the screen."""
        return self.scheduler.seen

    def mark_tracks(self) -> tuple[MarkTrack, ...]:
        """Return how far marked things are over the frames.

        Marks on files are known at the frames in memory, marks in scenes once they were measured.
        """
        if self.has_scene:
            return self.scene_tracks.tracks()
        timeline = self.timeline
        return self._plate_tracks.tracks(timeline.cache, timeline.runs(), self.shot.marks)

    @property
    def _is_measuring_late(self) -> bool:
        """Return True while there is work that comes before measuring how far marks are."""
        return self.scheduler.is_rendering or self.marks.is_reading

    # What can be done

    def say(self, sentence: str) -> None:
        """Show a sentence in the status bar for a while."""
        self.messages.say(sentence)

    def say_error(self, error: HeatlensError) -> None:
        """Show what went wrong; after a fault of the program the work in hand is kept first."""
        if isinstance(error, FaultError):
            self.documents.keep_now()
        self.say(Problem(error))

    # What happens by itself

    def poll(self) -> None:
        """Take what threads have read; errors are said, and the last good picture stays."""
        try:
            with faults_told("What was read could not be shown"):
                self._take_news()
        except HeatlensError as error:
            self.say_error(error)
            self.start_choices.refused()
        self._lost_surfaces.look(self.source.plate)
        if self.source.plate is None:
            self.sides.restart()  # what was under way read from the plate that left the GPU
        # Why a file was refused is all that the start screen has to tell: it stays until the user
        # opens something else or goes back.
        self.messages.fade(keeps_problem=self.start_choices.is_wanted)
        self.speed.is_for_ring = self.ring.is_turning

    def drawn(self) -> None:
        """Take note that what was drawn is on the screen now."""
        seen = self.seen
        self.ring.seen(None if seen is None else seen.shot.lens_at(seen.frame))

    def _reload_shaders(self) -> None:
        """Draw with shaders whose files have changed; a mistake in them is only said."""
        news = self._shaders.poll() if self._shaders is not None else None
        if news is not None:
            self.say(news.sentence)
        if news is not None and news.programs:
            self.source.picture.count_again()
            self.color.draw_again()

    def _take_news(self) -> None:
        self._reload_shaders()
        opened = self.source.arrived()
        if opened is not None:
            self._begin(opened)
        if self.references.poll():
            self.say(f"B is {self.reference.path.name}." if self.reference else "")
        for poll in (
            *(self.recent.poll, self.files.poll, self.exports.poll, self.pictures.poll),
            *(self.documents.poll, self.marks.poll, self.scene_tracks.poll, self.clips.poll),
            *(self.player.poll, self.sent_lens.poll, self.ring.poll, self.recording.poll),
            self.ring_out.poll,
            self.pull.poll,
        ):
            poll()

    def _begin(self, opened: Opened) -> None:
        """Begin a shot of another file or renderer; the same file read anew keeps its shot."""
        self.pull.begin()
        self.recording.keep()
        self.sides.restart()
        is_same = self.shot.source == opened.text
        coming = self.documents.taken(opened) if opened.source.is_repeatable else None
        self.editing.frame = opened.frame
        self.messages.clear()
        self.given.opened(opened.text)
        self.start_choices.opened()
        start_lens, problem = first_lens(opened, self.given)
        self.lens_commands.begun_with = start_lens
        self._say_all(problem)
        if coming is not None:
            self.editing.begin(coming)
        elif not is_same:
            self._begin_shot(opened, start_lens.lens)
        elif opened.cache is not None:  # its files were read again, perhaps in another way
            self.editing.edit(replace(self.shot, plate_options=opened.options))
        else:
            self.clips.arrived()
        self._say_all(*opened.notes, self._color_note(opened))
        self._lost_surfaces.begin(opened.notes)
        self.files.arrived(opened)

    def _begin_shot(self, opened: Opened, lens: Lens) -> None:
        shot = opened.shot(lens, self.shot.defocus)
        timecode = shot.timecode_at(opened.frame, timecode_of(opened.attributes))
        first = None if timecode is None else (opened.frame, timecode)
        filmed, said = with_given_camera(shot, self.given, first)
        self._say_all(said)
        if filmed is not shot and shot.frames is None and self.given.start.camera is not None:
            self.editing.frame = self.given.start.camera.frames[0]
        self.editing.begin(filmed)
        self.documents.begun()
        self.view = replace(self.view, zoom=None, center_px=None)

    def _color_note(self, opened: Opened) -> str:
        """Take the colours as the header tells them, alike for all frames; a scene has none."""
        self.view = self.color.of_plate(self.view, opened.attributes)
        return self.color.input_of(self.view.input_space).note

    def _say_all(self, *sentences: str) -> None:
        said = " ".join(sentences).strip()
        if said:
            self.say(said)

    def work(self) -> None:
        """Go on for a moment with the whole picture, else with the frames of the pull."""
        self.scheduler.work()

    @property
    def wants_frames(self) -> bool:
        """Return True while a gesture waits to become a step, or a shot to be kept."""
        return self.editing.is_unsettled or self.documents.is_behind

    def seconds_until_needed(self) -> float | None:
        """Return how long the loop may sleep without an event; None: until there is one."""
        waits = (
            _SETTLING_S if self.wants_frames else None,
            _NEXT_SLICE_S if self.scene_tracks.is_due else None,
            self.messages.seconds_until_needed(),
            self.scheduler.seconds_until_needed(),
            self.player.seconds_until_needed(),
            self.ring.seconds_until_needed(),
            self.ring_out.seconds_until_needed(),
            shader_reload.EVERY_S if self._shaders is not None else None,
        )
        return min((wait for wait in waits if wait is not None), default=None)

    def remember(self, **window: object) -> None:
        """Keep what may have changed; `window` are further fields of Remembered."""
        view, playback = self.view, self.timeline.playback
        self.preferences.change(
            display=view.display,
            view=self.color.chosen_view(view),
            unit=view.unit,
            guides=replace(view.guides, desqueeze=None),  # which is of what is open
            peaking=view.peaking,
            ending=playback.ending,
            every_frame=playback.is_every_frame,
            **window,
        )
        try:
            self.preferences.save()
        except InputError as error:
            self.say(Problem(error))

    def close(self) -> None:
        """End all threads; a picture that is being written is finished, an export stopped."""
        self.pictures.saver.close()
        self.exports.close()
        self.documents.close()
        self.pull.close()
        self.source.close()
