"""The controls of a session: for each subject, such as time or pictures, its commands and workers.

A front end uses those of the subjects that it shows; the session polls the `workers` of each.
"""

from collections.abc import Mapping
from pathlib import Path

from heatlens.core.base.messages import Worker
from heatlens.core.model.keys.key_rows import CAMERA, Row, RowChoice
from heatlens.core.model.view.picture_view import PictureView
from heatlens.render.display.color_choice import ColorChoice
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.preview.speed import Speed
from heatlens.render.rendered_frames.screen_work import ScreenWork
from heatlens.studio.board.notices import Notices
from heatlens.studio.session.exports.export_commands import ExportCommands
from heatlens.studio.session.files.file_commands import FileCommands
from heatlens.studio.session.files.open_reel import OpenReel
from heatlens.studio.session.files.shot_documents import ShotDocuments
from heatlens.studio.session.files.start_choices import RecentFiles, StartChoices
from heatlens.studio.session.keys.key_commands import KeyCommands
from heatlens.studio.session.lens.lens_commands import LensCommands
from heatlens.studio.session.lens.lens_imports import FramingImport
from heatlens.studio.session.live.pull_recording import PullRecording
from heatlens.studio.session.live.ring_follower import RingFollower, RingOut
from heatlens.studio.session.live.ring_recording import RingRecording
from heatlens.studio.session.live.sent_lens import SentLens
from heatlens.studio.session.marks.mark_commands import MarkCommands
from heatlens.studio.session.marks.mark_measuring import SceneMarkTracks
from heatlens.studio.session.pictures.channel_view import ChannelView
from heatlens.studio.session.pictures.compare_sides import CompareSides
from heatlens.studio.session.pictures.live_picture import LivePicture
from heatlens.studio.session.pictures.look_commands import LookCommands
from heatlens.studio.session.pictures.picture_commands import PictureCommands
from heatlens.studio.session.pictures.picture_view import PictureDisplay
from heatlens.studio.session.pictures.program_builder import ProgramBuilder
from heatlens.studio.session.pictures.shot_reference import ShotReference
from heatlens.studio.session.pictures.view_commands import ReferenceLoader, ViewCommands
from heatlens.studio.session.playing.ahead_jobs import AheadJobs
from heatlens.studio.session.playing.cached_screen import CachedScreen
from heatlens.studio.session.playing.cluster_frames import ClusterFrames, WholePictures
from heatlens.studio.session.playing.frame_player import FramePlayer
from heatlens.studio.session.playing.frames_ahead import FramesAhead, store_of
from heatlens.studio.session.playing.render_scheduler import RenderScheduler, VisibleWork
from heatlens.studio.session.scenes.scene_commands import SceneCommands
from heatlens.studio.session.shared import Shared
from heatlens.studio.session.time.focus_track import MarkTrack, MarkTracks
from heatlens.studio.session.time.timeline import Timeline


class PictureControl:
    """Viewing and saving the picture: view, comparison, looks, files; frames that others render."""

    def __init__(self, shared: Shared, timeline: Timeline, frames_folder: Path | None) -> None:
        start = shared.command_line.start
        self.renderer: FrameRenderer = shared.source.picture.renderer
        self.notify = shared.notify
        self.color = ColorChoice(start.ocio, shared.notify)
        first_view = shared.preferences.first_view(start.view)
        self.view = PictureView(self.color.limit_to_config(first_view))
        self.display = PictureDisplay(shared.editing, self.view, self.color)
        self.references = ReferenceLoader(shared)
        self.commands = ViewCommands(shared, self.view, self.references)
        self.frame_jobs = AheadJobs(shared, timeline, self.view)
        self.frame_store = store_of(shared.preferences.values, frames_folder, shared.wake)
        self.cluster = ClusterFrames(shared, jobs=self.frame_jobs, store=self.frame_store)
        self.builder = ProgramBuilder(shared, frames_folder)
        self.sides = CompareSides(
            self.renderer, WholePictures(self.renderer, self.cluster), self.builder
        )
        self.channel = ChannelView(shared, self.view)
        self.other_shot = ShotReference(shared, self.sides, self.view)
        self.looks = LookCommands(shared, self.view)
        self.saving = PictureCommands(shared, self.display, self.live)
        self.workers: tuple[Worker, ...] = (
            *(self.references, self.other_shot, self.channel, self.saving, self.builder),
        )

    def use_header_color_space(self, attributes: Mapping[str, object]) -> str:
        """Use the color space of a plate's header; return a note about it, or ""."""
        self.view.state = self.color.adapt_to_plate(self.view.state, attributes)
        return self.color.plate_input_space(self.view.state.input_space).note

    @property
    def live(self) -> LivePicture:
        """The picture through the lens, side A of the comparison."""
        return self.sides.a


class LensControl:
    """The lens, the devices that turn it, and the programs that receive it."""

    def __init__(self, shared: Shared) -> None:
        start, editing, notify = shared.command_line.start, shared.editing, shared.notify
        self.commands = LensCommands(shared)
        self.ring = RingFollower(
            start.lens_in, editing, notify, shared.preferences, wake=shared.wake
        )
        sent = SentLens(shared, self.commands)
        ring_out = RingOut(start.lens_out, editing, notify, shared.source.timecode_at)
        self.workers: tuple[Worker, ...] = (sent, self.ring, ring_out)


class TimeControl:
    """Everything about frames: timeline, keys, marks, recorded pulls, rendered frames."""

    workers: tuple[Worker, ...]

    def __init__(
        self,
        shared: Shared,
        timeline: Timeline,
        pictures: PictureControl,
        lens: LensControl,
        scenes: SceneCommands,
        speed: Speed,
        screen: ScreenPictures | None,
    ) -> None:
        """Create it; cached frames are shown on `screen`, unless it is None."""
        source, editing = shared.source, shared.editing
        preferences, view = shared.preferences.values, pictures.view
        self._source, self.editing, self.speed = source, editing, speed
        self.notify, self.scenes, self.timeline = shared.notify, scenes, timeline
        timeline.playback.ending = preferences.ending
        timeline.playback.is_every_frame = preferences.every_frame
        rows = RowChoice(lambda: source.has_camera)
        self.keys, ring = KeyCommands(shared, rows, scenes.set_key), lens.ring
        self.marks = MarkCommands(shared, timeline, scenes)
        visible = VisibleWork(source, pictures.sides)
        self._plate_tracks = MarkTracks(self.marks.matte_distances)
        self.scene_tracks = tracks = SceneMarkTracks(
            shared, timeline, scenes, lambda: visible.is_rendering or self.marks.is_reading
        )

        def make_screen(frames_ahead: FramesAhead) -> ScreenWork:
            if screen is None:
                return ScreenWork()
            return CachedScreen(frames_ahead, source, editing, view, screen)

        self.frames_ahead = FramesAhead(
            *(shared, pictures.frame_jobs, pictures.frame_store, pictures.cluster, timeline, view),
            *(lambda: visible.is_rendering or tracks.is_due, lambda: ring.is_turning, make_screen),
        )
        self.player = FramePlayer(shared, timeline, self.frames_ahead)
        ring_recording = RingRecording(ring, source, editing)
        self.recording = PullRecording(shared, timeline, rows, ring_recording)
        self.scheduler = RenderScheduler(
            shared, pictures.sides, visible, self.frames_ahead, view, speed
        )
        self.workers = (*self.marks.workers, tracks, self.player, self.recording, self.frames_ahead)

    def toggle_key(self, row: Row) -> None:
        """Set a key of a row at the playhead, or remove the one that is there."""
        if row is CAMERA:
            self.scenes.toggle_key()
        else:
            self.keys.toggle_here(row)

    def mark_tracks(self) -> tuple[MarkTrack, ...]:
        """Return the distances of the marks over the frames.

        For plates, distances are known at the frames in memory. For scenes, they are known at the
        frames measured so far.
        """
        if self._source.has_camera:
            return self.scene_tracks.tracks()
        timeline, marks = self.timeline, self.editing.shot.marks
        return self._plate_tracks.tracks(timeline.cache, timeline.runs(), marks)


class FileControl:
    """Files: opening, saving, exporting, and the preferences."""

    def __init__(
        self,
        shared: Shared,
        pictures: PictureControl,
        timeline: Timeline,
        frames_folder: Path | None,
    ) -> None:
        self.documents = documents = ShotDocuments(shared, timeline)
        self.exports = ExportCommands(
            shared, timeline, pictures.display, lambda: documents.shot_name
        )
        self.reel = reel = OpenReel(shared, documents, timeline.playback, frames_folder)
        self.commands = FileCommands(
            *(shared, documents, pictures.saving, pictures.references, pictures.other_shot),
            *(reel, self.exports.write_sheet, FramingImport(shared, pictures.view)),
        )
        self.notices = Notices(
            *(shared, timeline, pictures.cluster, self.commands.reading, reel),
            self.commands.reel_editing,
        )
        self.recent = RecentFiles(shared)
        self.start_choices = StartChoices(shared, timeline.playback, self.commands, self.recent)
        self.workers: tuple[Worker, ...] = (
            self.recent,
            self.commands,
            self.exports,
            documents,
            documents.unreadable,
            reel,
        )

    @property
    def window_title(self) -> str:
        """The open shot of a reel, else the shot's file or the open file; a star for changes."""
        title = self.documents.window_title
        if not self.reel.title:
            return title
        return f"{self.reel.title}{' *' if title.endswith(' *') else ''}"
