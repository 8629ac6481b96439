"""The program behind the window: the open document and everything that can be done with it.

A session needs no window. Its pictures come from the same renderer that `heatlens render` uses.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from heatlens.base.errors import FaultError, HeatlensError
from heatlens.base.faults import faults_reported
from heatlens.gpu import shader_reload
from heatlens.model.depth_histogram import DepthHistogram
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.model.view import ViewState
from heatlens.model.view_geometry import PictureShape
from heatlens.plate.header.timecode import timecode_of
from heatlens.preview.shown import Shown
from heatlens.render import FrameRenderer
from heatlens.session.exports.export_commands import ExportCommands
from heatlens.session.files.file_commands import FileCommands
from heatlens.session.files.shot_documents import ShotDocuments
from heatlens.session.files.start_choices import StartChoices
from heatlens.session.keys.key_commands import KeyCommands
from heatlens.session.keys.key_rows import RowChoice
from heatlens.session.lens.lens_commands import LensCommands
from heatlens.session.live.pull_recording import PullRecording
from heatlens.session.live.ring_hand import RingHand
from heatlens.session.live.ring_out import RingOut
from heatlens.session.live.ring_take import RingTake
from heatlens.session.live.sent_lens import SentLens
from heatlens.session.loop.messages import Lasting, Messages, Problem
from heatlens.session.loop.speed import Speed
from heatlens.session.loop.worker import Worker
from heatlens.session.marks.mark_commands import MarkCommands
from heatlens.session.marks.scene_mark_tracks import SceneMarkTracks
from heatlens.session.opened.lost_surfaces import LostSurfaces
from heatlens.session.opened.open_source import OpenSource
from heatlens.session.pictures.color_choice import ColorChoice
from heatlens.session.pictures.compare_sides import CompareSides
from heatlens.session.pictures.live_picture import LivePicture
from heatlens.session.pictures.look_commands import LookCommands
from heatlens.session.pictures.picture_commands import PictureCommands
from heatlens.session.pictures.picture_view import PictureLook, PictureView
from heatlens.session.pictures.reference import Reference, ReferenceLoader
from heatlens.session.pictures.view_commands import ViewCommands
from heatlens.session.pictures.visible_work import VisibleWork
from heatlens.session.playing.frame_player import FramePlayer
from heatlens.session.playing.pull_jobs import PullJobs
from heatlens.session.playing.render_scheduler import RenderScheduler
from heatlens.session.playing.rendered_pull import RenderedPull, store_of
from heatlens.session.scenes.clip_choice import ClipChoice
from heatlens.session.scenes.scene_commands import SceneCommands
from heatlens.session.settings.preferences import Preferences
from heatlens.session.settings.recent_files import RecentFiles
from heatlens.session.shot.editing import Editing
from heatlens.session.shot.start import GivenOptions, Start
from heatlens.session.shot.start_shot import first_lens, with_given_camera
from heatlens.session.time.focus_track import MarkTrack, MarkTracks
from heatlens.session.time.timeline import Timeline
from heatlens.source.opened import Opened

_SETTLING_S = 0.1  # between checks whether a gesture has ended or an autosave is due


class Session:
    """The open document and its commands; panels and the main loop use it."""

    def __init__(
        self,
        renderer: FrameRenderer,
        start: Start,
        wake: Callable[[], None] = lambda: None,
        preferences: Preferences | None = None,
        frames_folder: Path | None = None,
        is_software: bool = False,
    ) -> None:
        """Begin with the values of the command line, `start`.

        Threads call `wake` to have the window drawn. Rendered frames are kept in `frames_folder`,
        or in memory only if None. `is_software` says that a software rasteriser draws the window.
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
        self.source = OpenSource(renderer, wake, start.stream, self.given.placing_of)
        self.editing = Editing(
            Shot(Lens(50.0, 2.8, 2.0, 36.0), start.defocus),
            say,
            is_sequence=lambda: self.source.is_sequence,
        )
        self.references = ReferenceLoader(renderer.ctx, say, wake)
        self.lens_commands = LensCommands(self.source, self.editing, say)
        self.view_commands = ViewCommands(
            self.picture_view, self.source, self.editing, self.references, say
        )
        self.sides = CompareSides(renderer)
        self.looks = LookCommands(self.editing, self.picture_view, say)
        timed = self._timed_workers(say, wake, frames_folder)
        filed = self._file_workers(say, wake)
        # Polled in this order in each frame of the window.
        self._workers: tuple[Worker, ...] = (
            self.references,
            *filed,
            *timed,
            self.scheduler,
            self.messages,
        )
        self._shaders = shader_reload.ShaderReload() if shader_reload.is_on() else None

    def _timed_workers(
        self, say: Callable[[str], None], wake: Callable[[], None], frames_folder: Path | None
    ) -> tuple[Worker, ...]:
        """Create timeline, keys, marks, the scene's camera, playback and rendering."""
        source, editing, view = self.source, self.editing, self.picture_view
        now = self.preferences.now
        self.timeline = timeline = Timeline(source, editing, say)
        timeline.playback.ending, timeline.playback.is_every_frame = now.ending, now.every_frame
        self.scenes = SceneCommands(source, editing, say)
        self.clips = ClipChoice(source, editing)
        rows = RowChoice(lambda: source.has_camera)
        self.keys = KeyCommands(editing, rows, self.scenes.set_key, say)
        self.marks = marks = MarkCommands(source, editing, timeline, self.scenes, say, wake)
        visible = VisibleWork(source, self.sides)
        self._plate_tracks = MarkTracks()
        self.scene_tracks = SceneMarkTracks(
            source, editing, timeline, self.scenes, lambda: visible.is_rendering or marks.is_reading
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
        self.ring = RingHand(
            self.given.start.lens_in,
            editing,
            say,
            self.preferences,
            wake=wake,
            on_turn=self.pull.touched,  # do not render ahead while it turns
        )
        self.player = FramePlayer(timeline, source, editing, self.pull, say)
        self.recording = PullRecording(
            editing, timeline, rows, RingTake(self.ring, source, editing), say
        )
        self.scheduler = RenderScheduler(
            source, self.sides, visible, self.pull, editing, view, self.speed, self.say_error
        )
        sent_lens = SentLens(source, editing, self.given, self.lens_commands, say)
        ring_out = RingOut(self.given.start.lens_out, editing, say, source.timecode_at)
        return (
            *(self.marks, self.scene_tracks, self.clips, self.player, sent_lens),
            *(self.ring, self.recording, ring_out, self.pull),
        )

    def _file_workers(
        self, say: Callable[[str], None], wake: Callable[[], None]
    ) -> tuple[Worker, ...]:
        """Create documents, files and exports."""
        source, editing, view = self.source, self.editing, self.picture_view
        preferences, stream = self.preferences, self.given.start.stream
        self.documents = ShotDocuments(
            source, editing, self.timeline, preferences, self.given, say, wake
        )
        look = PictureLook(editing, view, self.color)
        self.pictures = PictureCommands(source, editing, look, self.live, say, wake)
        self.exports = ExportCommands(source, editing, self.timeline, look, say, wake)
        self.exports.shot_name = lambda: self.documents.shot_name
        self.files = FileCommands(
            source,
            editing,
            self.documents,
            self.pictures,
            self.references,
            preferences,
            self.given,
            self.exports.write_sheet,
            say,
            wake,
        )
        self.recent = RecentFiles(preferences, stream.text if stream else None, wake)
        self.start_choices = StartChoices(
            source, self.timeline.playback, self.files, self.recent, self.given
        )
        return (self.recent, self.files, self.exports, self.pictures, self.documents)

    def begin(self) -> None:
        """Open the file that the command line named, if it named one."""
        self.files.open_first()

    # State

    @property
    def renderer(self) -> FrameRenderer:
        """The renderer of all pictures."""
        return self.source.picture.renderer

    @property
    def live(self) -> LivePicture:
        """The picture through the lens, side A of the comparison."""
        return self.sides.a

    @property
    def view(self) -> ViewState:
        """The view state: exposure, zoom, overlay, comparison."""
        return self.picture_view.state

    @view.setter
    def view(self, state: ViewState) -> None:
        self.picture_view.state = state

    @property
    def is_plain(self) -> bool:
        """True while only the live picture through the lens is shown."""
        return self.picture_view.is_lens_alone and not self.pull.is_alone

    @property
    def message(self) -> str:
        """The message in the status bar, or ""."""
        return self.messages.text

    @property
    def shot(self) -> Shot:
        """The current shot."""
        return self.editing.shot

    @property
    def lens(self) -> Lens:
        """The lens of the shot at the playhead."""
        return self.editing.lens

    @property
    def frame(self) -> int:
        """The frame at the playhead."""
        return self.editing.frame

    @property
    def has_camera(self) -> bool:
        """True if what is open is seen by a camera that moves."""
        return self.source.has_camera

    @property
    def has_many_views(self) -> bool:
        """True if what is open can be seen from many points of the lens."""
        return self.source.picture.renderer.has_many_views

    @property
    def histogram(self) -> DepthHistogram | None:
        """The histogram of the plate's distances; None if it has none."""
        return self.source.picture.histogram

    @property
    def reference(self) -> Reference | None:
        """The reference picture, to be shown as B; None if none is loaded."""
        return self.references.current

    @property
    def picture_shape(self) -> PictureShape:
        """The shape of the display window; one pixel while nothing is open."""
        return self.source.picture_shape(self.shot)

    @property
    def seen(self) -> Shown | None:
        """The picture through the lens to show."""
        return self.scheduler.seen

    def mark_tracks(self) -> tuple[MarkTrack, ...]:
        """Return the distances of the marks over the frames.

        For plates they are known at the frames in memory, for scenes at the frames measured so far.
        """
        if self.has_camera:
            return self.scene_tracks.tracks()
        timeline = self.timeline
        return self._plate_tracks.tracks(timeline.cache, timeline.runs(), self.shot.marks)

    # Messages

    def say(self, sentence: str) -> None:
        """Show a sentence in the status bar for a while."""
        self.messages.say(sentence)

    def say_error(self, error: HeatlensError) -> None:
        """Show an error in the status bar; after a fault of the program, autosave first."""
        if isinstance(error, FaultError):
            self.documents.keep_now()
        self.say(Problem(error))

    # Called by the main loop

    def poll(self) -> None:
        """Take over what threads have read; report errors, and keep the last good picture."""
        try:
            with faults_reported("What was read could not be shown"):
                self._take_news()
        except HeatlensError as error:
            self.say_error(error)
            self.start_choices.refused()
        self._lost_surfaces.look(self.source.plate)
        if self.source.plate is None:
            self.sides.restart()  # work in progress used a plate that is no longer on the GPU
        # An error about a file stays on the start screen until the user opens something else or
        # goes back.
        self.messages.fade(keeps_problem=self.start_choices.is_wanted)
        self.speed.is_for_ring = self.ring.is_turning

    def drawn(self) -> None:
        """Note that the frame of the window is on the screen now."""
        seen = self.seen
        self.ring.seen(None if seen is None else seen.shot.lens_at(seen.frame))

    def _reload_shaders(self) -> None:
        """Use shaders whose files have changed; only report a mistake in them."""
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
        for worker in self._workers:
            worker.poll()
        if self.preferences.problem and not (self.messages.text or self.source.opener.opening):
            self.say(Lasting(self.preferences.problem))
            self.preferences.problem = ""

    def _begin(self, opened: Opened) -> None:
        """Begin with a newly opened source; a source that was only read again keeps its shot."""
        self.pull.begin()
        self.recording.keep()
        self.sides.restart()
        is_same = self.shot.source == opened.text
        coming = None if opened.again is None else self.documents.taken(opened)
        self.editing.frame = opened.frame
        self.messages.clear()
        self.given.opened(opened.text)
        self.start_choices.opened()
        start_lens, problem = first_lens(opened, self.given)
        self.lens_commands.start_lens = start_lens
        self._say_all(problem)
        if coming is not None:
            self.editing.begin(coming)
        elif not is_same:
            self._begin_shot(opened, start_lens.lens)
        elif opened.cache is not None:  # files were read again, perhaps with other options
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
        """Apply the colour space of the header; return a note about it, or ""."""
        self.view = self.color.of_plate(self.view, opened.attributes)
        return self.color.input_of(self.view.input_space).note

    def _say_all(self, *sentences: str) -> None:
        said = " ".join(sentences).strip()
        if said:
            self.say(said)

    def work(self) -> None:
        """Render for one time slice: visible pictures first, then frames ahead."""
        self.scheduler.work()

    @property
    def wants_frames(self) -> bool:
        """True while a gesture waits to become an undo step, or changes to be autosaved."""
        return self.editing.is_unsettled or self.documents.is_behind

    def seconds_until_needed(self) -> float | None:
        """Return how many seconds the loop may sleep; None to sleep until an event."""
        waits = (
            _SETTLING_S if self.wants_frames else None,
            shader_reload.EVERY_S if self._shaders is not None else None,
            *(worker.seconds_until_needed() for worker in self._workers),
        )
        return min((wait for wait in waits if wait is not None), default=None)

    def remember(self, **window: object) -> None:
        """Begin to save the preferences; `window` has further fields of Remembered."""
        view, playback = self.view, self.timeline.playback
        self.preferences.change(
            display=view.display,
            view=self.color.chosen_view(view),
            unit=view.unit,
            guides=replace(view.guides, desqueeze=None),  # which belongs to the open source
            peaking=view.peaking,
            ending=playback.ending,
            every_frame=playback.is_every_frame,
            **window,
        )
        self.documents.keep_preferences()

    def close(self) -> None:
        """Finish writing, stop an export, and end all threads."""
        for worker in self._workers:
            worker.close()
        self.source.close()
