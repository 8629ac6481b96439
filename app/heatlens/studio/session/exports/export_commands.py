"""Export frames, a movie or the lens as a camera in another process."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Problem, Worker, report_errors
from heatlens.core.base.paths import absolute
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.option import changed_options
from heatlens.core.model.shot.settings import Quality
from heatlens.core.model.view.guides import frame_lines_for
from heatlens.deliver.export.job import blur_of_export
from heatlens.deliver.farm.export_place import HERE, LeftExport, Where, shot_of_job
from heatlens.deliver.farm.export_process import ExportRun, ExportState
from heatlens.media.documents.shot_file import read_shot
from heatlens.studio.session.pictures.picture_view import PictureDisplay
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline
from heatlens.studio.settings.export_settings import ExportSettings, count_files, proposed_settings


class ExportCommands(Commands, Worker):
    """Exports the open shot as it is at the start of the export, and reports how it ended."""

    def __init__(
        self,
        shared: Shared,
        timeline: Timeline,
        display: PictureDisplay,
        shot_name: Callable[[], str],
    ) -> None:
        """Create it; `shot_name` returns the name of the shot's file, for the burn-in."""
        super().__init__(shared)
        self.notify = shared.notify
        self._timeline, self._display, self._shot_name = timeline, display, shot_name
        self.run = ExportRun(self._wake)
        self.settings = ExportSettings()
        self._proposed_source: str | None = (
            None  # the source that folder and name were proposed for
        )
        self.existing_words = ""  # which files are there already, until the user has answered
        self._reported: ExportState | None = None  # the export whose end was reported

    @property
    def why_not(self) -> str:
        """The reason why nothing can be exported now; "" if exporting is possible."""
        return "" if self.run.is_busy else self._source.why_shown_once

    # The frames come from the timeline, because it knows the files. A shot file need not name its
    # frames: from the shot alone, the tab would show "one frame" for a sequence, and a keyed shot
    # would be exported only at the frames between its keys.
    @property
    def played(self) -> FrameRange | None:
        """The frames from in to out, which are exported if no others are named; None for a still.

        The shot file of a sequence need not list its frames: they follow from the files on disk.
        """
        return self._timeline.timed_shot.played_frames

    @property
    def usual_quality(self) -> Quality:
        """The quality of an export, if the panel names none."""
        return blur_of_export(self._editing.shot).effective_quality

    @property
    def shown_quality(self) -> Quality:
        """The quality of the picture that the window shows at rest."""
        return self._editing.shot.defocus.effective_quality

    def propose(self) -> None:
        """Propose folder and name for a newly opened plate; note whether one frame is exported."""
        plate, source = self._source.plate, self._editing.shot.source
        if plate is not None and source != self._proposed_source:
            place = self._preferences.values.export_place
            self.settings, self._proposed_source = proposed_settings(plate.path, place), source
        is_single = self.played is None or self.played.count == 1
        self.settings = replace(self.settings, is_single=is_single)

    def change(self, settings: ExportSettings) -> None:
        """Set everything; a place that was chosen is remembered, and used at once."""
        if settings.place != self.settings.place:
            self._preferences.change(export_place=settings.place)
        self.settings = settings

    def request_export(self) -> None:
        """Start to export, unless files are there already: then the user is asked first."""
        count = 0 if self.settings.place.is_job else count_files(self.settings.output)
        if count:
            files = "file of this name is" if count == 1 else "files of this name are"
            self.existing_words = f"{count} {files} in {self.settings.folder} already."
        else:
            self.export()

    def answer_existing(self, exports_over: bool) -> None:
        """Answer the question about files that are there already."""
        self.existing_words = ""
        if exports_over:
            self.export()

    def export(self) -> None:
        """Start to export the frames or the movie that is set in the panel."""
        guides = self._display.view.state.guides
        shape = self._source.picture_shape(self._editing.shot)
        if not frame_lines_for(guides.canvases, shape.width_px, shape.height_px):
            guides = replace(guides, canvases=())  # of pictures with another shape
        job = self.settings.job(self._display.options(), guides, self._shot_name())
        shot = self.settings.shot_at_quality(self._timeline.timed_shot)
        place = self.settings.place
        self._preferences.change(export_place=place)
        self._make_folder_and_run(lambda: self.run.export(shot, self.settings.output, job, place))

    def write_camera(self) -> None:
        """Start to write the lens as a camera file."""
        self._make_folder_and_run(
            lambda: self.run.camera(self._timeline.timed_shot, self.settings.camera_output)
        )

    def write_sheet(self, path: Path, title: str) -> None:
        """Start to write the focus pull as a page to print for the set, with a table beside it."""
        if self.run.is_busy:
            self._notify(
                Problem("An export is running: write the pull sheet when it has finished.")
            )
            return
        words = ["--title", title, *changed_options(self._display.options())]
        with report_errors(self._notify):
            self.run.sheet(self._timeline.timed_shot, str(path), words)

    def _make_folder_and_run(self, run: Callable[[], None]) -> None:
        """Make the folder of the export and call `run`; show a message if either fails."""
        try:
            Path(self.settings.folder).expanduser().mkdir(parents=True, exist_ok=True)
            run()
        except OSError as error:
            self._notify(f"{self.settings.folder} cannot be made: {error.strerror or error}.")
        except HeatlensError as error:
            self._notify(Problem(error))

    def poll(self) -> None:
        """Resume an export that was left, and report how one has ended; call this once a frame."""
        left_exports = self._preferences.values.left_exports
        if left_exports and self._source.plate is not None and not self.run.is_busy:
            self._resume_export(left_exports)
        state = self.run.state
        if state is not None and state.code is not None and state is not self._reported:
            self._reported = state
            self._notify(
                state.last_sentence
                if state.code == 0 or state.is_stopped
                else Problem(state.last_sentence)
            )

    def _resume_export(self, left_exports: Mapping[str, LeftExport]) -> None:
        """Restart the export of the open source that was left; finished frames are not repeated."""
        export = left_exports.get(self._left_export_key)
        if export is None:
            return
        other_exports = {
            name: other_export
            for name, other_export in left_exports.items()
            if name != self._left_export_key
        }
        self._preferences.change(left_exports=other_exports)
        agreed_cluster = self._preferences.values.cluster
        if agreed_cluster is None or agreed_cluster.scheduler != export.scheduler:
            self._notify(
                f"The cluster at {export.scheduler} may have gone on with the export to "
                f"{export.output}: export again to follow it."
            )
            return
        export_place = replace(
            HERE, where=Where.CLUSTER, scheduler=export.scheduler, agreed=agreed_cluster
        )
        with report_errors(self._notify):
            shot = read_shot(shot_of_job(export.output))
            self.run.export(shot, export.output, export.job, export_place)
            self._notify(f"The cluster has gone on with the export to {export.output}.")

    @property
    def _left_export_key(self) -> str:
        """The key of the open source in the exports that were left to a cluster."""
        return absolute(self._editing.shot.source or "")

    def close(self) -> None:
        """Stop an export and keep its finished frames, or leave it to the cluster that makes it."""
        left_export = self.run.close()
        if left_export is not None:
            left_exports = self._preferences.values.left_exports
            self._preferences.change(
                left_exports={**left_exports, self._left_export_key: left_export}
            )
            save = self._preferences.save_function()
            with report_errors(self._notify):
                if save is not None:
                    save()
