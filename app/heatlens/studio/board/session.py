"""The program behind a front end: the open document and all commands on it.

A session needs no window. Its pictures come from the same renderer that `heatlens render` uses. It
watches for changed shaders and missing surfaces.
"""

from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import FaultError, HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.core.base.messages import Lasting, Messages, Problem, Worker
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.header.timecode import timecode_of
from heatlens.render.display.color_choice import ColorChoice
from heatlens.render.display.front_end import FrontEnd
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu import shader_reload
from heatlens.render.preview.speed import Speed
from heatlens.render.source.opened import Opened
from heatlens.studio.board.controls import FileControl, LensControl, PictureControl, TimeControl
from heatlens.studio.board.facts import Facts, FactsReader
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.scenes.scene_commands import SceneCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.session.time.timeline import Timeline
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import (
    CommandLineOptions,
    Start,
    first_lens,
    with_given_camera,
)


class ShaderWatch(Commands, Worker):
    """Reports reloaded shaders and draws everything again; a faulty shader is only reported.

    It does nothing unless the environment asks for it, see `render/gpu/shader_reload.py`.
    """

    def __init__(self, shared: Shared, color: ColorChoice) -> None:
        super().__init__(shared)
        self._picture = shared.source.picture
        self._color = color
        self._reload = shader_reload.ShaderReload() if shader_reload.is_on() else None

    def poll(self) -> None:
        """Use changed shaders; call this once a frame. Notifies the user."""
        reload_result = None if self._reload is None else self._reload.poll()
        if reload_result is None:
            return
        self._notify(reload_result.message)
        if reload_result.programs:
            self._picture.mark_changed()
            self._color.rebuild()

    def seconds_until_needed(self) -> float | None:
        """Return the time between two checks of the files; None if none are checked."""
        return None if self._reload is None else shader_reload.EVERY_S


class LostSurfaces(Commands, Worker):
    """Watches the pictures of a source for notes about lost surfaces."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._reported_notes: tuple[str, ...] = ()
        self._is_reported = False

    def restart(self, notes: tuple[str, ...]) -> None:
        """Begin with another source; `notes` have been reported already."""
        self._reported_notes = notes
        self._is_reported = False

    def poll(self) -> None:
        """Report the note of the first picture that has one."""
        plate = self._source.plate
        if self._is_reported or plate is None or not plate.surfaces_lost:
            return
        self._is_reported = True
        if plate.surfaces_lost not in self._reported_notes:
            self._notify(plate.surfaces_lost)


_SETTLING_S = 0.1  # interval of checks whether a gesture has ended or an autosave is due


_NOBODY = FrontEnd()


# All workers are in one tuple, which is also the order in which they are polled. With one list for
# polling and one for waiting, a worker that was missing in one of them would not run.
class Session:
    """The open document, its commands and its facts; a front end drives it.

    The commands are in `pictures`, `time`, `lens`, `scenes` and `files`; `facts` tells
    what is true now. The turns of a loop call `poll`, `update`, `work` and `note_drawn`, see
    `LoopTurn`. `moment` counts what may have changed the facts.
    """

    def __init__(
        self,
        renderer: FrameRenderer,
        start: Start,
        front_end: FrontEnd = _NOBODY,
        preferences: Preferences | None = None,
        frames_folder: Path | None = None,
        is_software: bool = False,
    ) -> None:
        """Begin with the values of the command line, `start`.

        `front_end` shows it. Rendered frames are kept in `frames_folder`, or in memory only if
        None. With `is_software`, a software rasterizer draws the window.
        """
        self.messages, self.screen, self.moment = Messages(), front_end.screen, 0
        notify, wake = self.messages.notify, front_end.wake
        self.preferences = preferences or Preferences()
        self.given = options = CommandLineOptions(start)
        self.source = source = OpenSource(renderer, wake, start.stream, options.placing_of)
        default_shot = Shot(Lens(50.0, 2.8, 2.0, 36.0), start.defocus)
        self.editing = editing = Editing(
            *(default_shot, notify, lambda: source.is_sequence, front_end.other_holder),
            lambda old_shot, new_shot: self.scenes.size.reframe(old_shot, new_shot),
        )
        shared = Shared(source, editing, self.preferences, options, notify, self.show_error, wake)
        self.scenes = SceneCommands(shared)
        timeline = Timeline(shared, lambda: self.files.reel.play_next_shot())
        self.pictures = pictures = PictureControl(shared, timeline, frames_folder)
        speed = Speed(is_software=is_software, has_window=front_end.has_window)
        self.lens = lens = LensControl(shared)
        self.time = time = TimeControl(
            *(shared, timeline, pictures, lens, self.scenes, speed, front_end.screen)
        )
        self.files = FileControl(shared, pictures, timeline, frames_folder)
        self._facts = FactsReader(source, editing, pictures, time, self.files, self.messages)
        self._lost_surfaces = LostSurfaces(shared)
        # Polled in this order in each frame of the window.
        self.workers: tuple[Worker, ...] = (
            ShaderWatch(shared, pictures.color),
            *(*pictures.workers, *self.files.workers, *lens.workers, *time.workers),
            *(self.scenes.clips, time.scheduler, self._lost_surfaces, self.messages),
        )

    def begin(self) -> None:
        """Open the file that the command line named, if it named one."""
        self.files.commands.open_first()

    def show_error(self, error: HeatlensError) -> None:
        """Show an error in the status bar; after a fault of the program, autosave first."""
        if isinstance(error, FaultError):
            self.files.documents.autosave_now()
        self.messages.notify(Problem(error))

    @property
    def facts(self) -> Facts:
        """What is true now, read anew; `Board.facts` keeps it for a turn."""
        return self._facts.read()

    # Called in the turns of a loop

    def poll(self) -> None:
        """Collect the results of threads; report errors, and keep the last good picture."""
        try:
            with report_faults("What was read could not be shown"):
                self._collect_results()
        except HeatlensError as error:
            if not self.files.commands.has_question:
                self.show_error(error)
            self.files.start_choices.show_after_failure()
        if self.source.plate is None:
            self.pictures.sides.restart()  # its work used a plate that is no longer on the GPU
        # An error about a file stays on the start screen until the user opens something else or
        # goes back.
        self.messages.fade(keeps_problem=self.files.start_choices.is_shown)
        self.time.speed.is_for_ring = self.lens.ring.is_turning
        self.moment += 1

    def update(self) -> None:
        """Answer what has changed with a picture that fits the time."""
        scheduler = self.time.scheduler
        before = scheduler.picture_key, scheduler.is_rendering
        scheduler.update()
        self.moment += (scheduler.picture_key, scheduler.is_rendering) != before

    def note_drawn(self) -> None:
        """Note that the frame of the window is on the screen now."""
        shown_picture = self.time.scheduler.shown_picture
        self.lens.ring.note_shown_lens(
            None if shown_picture is None else shown_picture.shot.lens_at(shown_picture.frame)
        )

    def _collect_results(self) -> None:
        """Begin a source that was opened, and poll all workers."""
        opened = self.source.switch_source()
        if opened is not None:
            self._begin_source(opened)
        for worker in self.workers:
            worker.poll()
        if self.preferences.problem and not (self.messages.text or self.source.opener.opening):
            self.messages.notify(Lasting(self.preferences.problem))
            self.preferences.problem = ""

    def _begin_source(self, opened: Opened) -> None:
        """Begin with a newly opened source; a source that was only read again keeps its shot."""
        editing, files = self.editing, self.files
        self.time.frames_ahead.restart()
        self.time.recording.finish()
        self.pictures.sides.restart()
        is_same = editing.shot.source == opened.text
        document_shot = (
            None if opened.render_source is None else files.documents.finish_opening(opened)
        )
        editing.frame = opened.frame
        self.messages.clear()
        self.given.note_opened(opened.text)
        files.start_choices.hide()
        start_lens, problem = first_lens(opened, self.given)
        self.lens.commands.start_lens = start_lens
        self._notify_together(problem)
        if document_shot is not None:
            editing.begin(document_shot)
        elif not is_same:
            self._begin_shot(opened, start_lens.lens)
        elif opened.cache is not None:  # files were read again, perhaps with other options
            editing.edit(replace(editing.shot, plate_options=opened.options))
        else:
            self.scenes.clips.apply_choice()
        self._notify_together(
            *opened.notes, self.pictures.use_header_color_space(opened.attributes)
        )
        self._lost_surfaces.restart(opened.notes)
        files.commands.remember_opened(opened)

    def _begin_shot(self, opened: Opened, lens: Lens) -> None:
        """Begin a shot without a file on a newly opened source, and notify the user."""
        shot = opened.shot(lens, self.editing.shot.defocus)
        timecode = shot.timecode_at(opened.frame, timecode_of(opened.attributes))
        frame_timecode = None if timecode is None else (opened.frame, timecode)
        camera_shot, note = with_given_camera(shot, self.given, frame_timecode)
        self._notify_together(note)
        if camera_shot is not shot and shot.frames is None and self.given.start.camera is not None:
            self.editing.frame = self.given.start.camera.frames[0]
        self.editing.begin(camera_shot)
        self.files.documents.begin_unnamed()
        self.pictures.commands.fit()

    def _notify_together(self, *sentences: str) -> None:
        """Show these sentences as one message; show nothing if all are empty."""
        message = " ".join(sentences).strip()
        if message:
            self.messages.notify(message)

    def work(self) -> None:
        """Render for one time slice: visible pictures first, then frames ahead."""
        self.time.scheduler.work()
        self.moment += 1

    @property
    def wants_frames(self) -> bool:
        """True while a gesture waits to become an undo step, or changes to be autosaved."""
        return self.editing.is_unsettled or self.files.documents.needs_autosave

    def seconds_until_needed(self) -> float | None:
        """Return how many seconds the loop may sleep; None to sleep until an event."""
        waits_s = (
            _SETTLING_S if self.wants_frames else None,
            *(worker.seconds_until_needed() for worker in self.workers),
        )
        return min((wait_s for wait_s in waits_s if wait_s is not None), default=None)

    def save_preferences(self, **window_fields: object) -> None:
        """Begin to save the preferences; `window_fields` are further fields of Remembered."""
        view, playback = self.pictures.view.state, self.time.timeline.playback
        self.preferences.change(
            display=view.display,
            view=self.pictures.color.chosen_view(view),
            unit=view.unit,
            guides=replace(view.guides, desqueeze=None, canvases=()),  # of the open source
            peaking=view.peaking,
            ending=playback.ending,
            every_frame=playback.is_every_frame,
            **window_fields,
        )
        self.files.documents.write_preferences()

    def close(self) -> None:
        """Finish writing, stop an export, and end all threads."""
        for worker in self.workers:
            worker.close()
        self.source.close()
