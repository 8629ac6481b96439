"""Export frames, a movie or the lens as a camera in another process."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.paths import absolute
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.option import words_of
from heatlens.core.model.shot.settings import Quality
from heatlens.core.model.view.guides import lines_of
from heatlens.deliver.export.job import blur_of_export
from heatlens.media.documents.shot_file import read_shot
from heatlens.studio.session.exports.export_process import ExportRun, ExportState
from heatlens.studio.session.exports.export_settings import ExportSettings, proposed_settings
from heatlens.studio.session.messages import Problem, Worker, reported
from heatlens.studio.session.pictures.picture_view import PictureDisplay
from heatlens.studio.session.settings.export_place import HERE, LeftExport, Where, shot_of_job
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline


class ExportCommands(Commands, Worker):
    """Exports the open shot as it is at the start of the export, and reports how it ended."""

    def __init__(
        self, shared: Shared, timeline: Timeline, look: PictureDisplay, shot_name: Callable[[], str]
    ) -> None:
        """Create it; `shot_name` returns the name of the shot's file, for the burn-in."""
        super().__init__(shared)
        self.say = shared.say
        self._timeline, self._look, self._shot_name = timeline, look, shot_name
        self.run = ExportRun(self._wake)
        self.settings = ExportSettings()
        self._of: str | None = None  # the source that folder and name were proposed for
        self._reported: ExportState | None = None  # the export whose end was reported

    @property
    def why_not(self) -> str:
        """The reason why nothing can be exported now; "" if exporting is possible."""
        return "" if self.run.is_busy else self._source.once_only

    # A shot file need not name its frames. The tab said "one frame" for such a shot over a
    # sequence, and a keyed one was exported at the frames between its keys only; the timeline is
    # asked now, which knows the files.
    @property
    def played(self) -> FrameRange | None:
        """The frames from in to out, which are exported if no others are named; None for a still.

        The shot file of a sequence need not list its frames: they follow from the files on disk.
        """
        return self._timeline.timed_shot.played

    @property
    def usual_quality(self) -> Quality:
        """The quality of an export, if the panel names none."""
        return blur_of_export(self._editing.shot).at_quality

    def propose(self) -> None:
        """Propose folder and name if another plate has been opened since the last proposal."""
        plate, source = self._source.plate, self._editing.shot.source
        if plate is not None and source != self._of:
            place = self._preferences.now.export_place
            self.settings, self._of = proposed_settings(plate.path, place), source
        is_single = self.played is None or self.played.count == 1
        self.settings = replace(self.settings, is_single=is_single)

    def change(self, settings: ExportSettings) -> None:
        """Set everything; a place that was chosen is remembered, and used at once."""
        if settings.place != self.settings.place:
            self._preferences.change(export_place=settings.place)
        self.settings = settings

    def export(self) -> None:
        """Start to export the frames or the movie that is set in the panel."""
        guides, shape = self._look.view.state.guides, self._source.picture_shape(self._editing.shot)
        if not lines_of(guides.canvases, shape.width_px, shape.height_px):
            guides = replace(guides, canvases=())  # of pictures with another shape
        job = self.settings.job(self._look.options(), guides, self._shot_name())
        shot = self.settings.shot_of(self._timeline.timed_shot)
        place = self.settings.place
        self._preferences.change(export_place=place)
        self._begin(lambda: self.run.export(shot, self.settings.output, job, place))

    def write_camera(self) -> None:
        """Start to write the lens as a camera file."""
        self._begin(lambda: self.run.camera(self._timeline.timed_shot, self.settings.camera_output))

    def write_sheet(self, path: Path, title: str) -> None:
        """Start to write the focus pull as a page to print for the set, with a table beside it."""
        if self.run.is_busy:
            self._say(Problem("An export is running: write the pull sheet when it has finished."))
            return
        words = ["--title", title, *words_of(self._look.options())]
        with reported(self._say):
            self.run.sheet(self._timeline.timed_shot, str(path), words)

    def _begin(self, run: Callable[[], None]) -> None:
        try:
            Path(self.settings.folder).expanduser().mkdir(parents=True, exist_ok=True)
            run()
        except OSError as error:
            self._say(f"{self.settings.folder} cannot be made: {error.strerror or error}.")
        except HeatlensError as error:
            self._say(Problem(error))

    def poll(self) -> None:
        """Follow an export that was left, and report how one has ended; call this once a frame."""
        left = self._preferences.now.left_exports
        if left and self._source.plate is not None and not self.run.is_busy:
            self._follow(left)
        state = self.run.state
        if state is not None and state.code is not None and state is not self._reported:
            self._reported = state
            self._say(state.said if state.code == 0 or state.is_stopped else Problem(state.said))

    def _follow(self, left: Mapping[str, LeftExport]) -> None:
        """Start the export again that was left for the open source: it finds what is done."""
        export = left.get(self._left_as)
        if export is None:
            return
        others = {name: it for name, it in left.items() if name != self._left_as}
        self._preferences.change(left_exports=others)
        agreed = self._preferences.now.cluster
        if agreed is None or agreed.scheduler != export.scheduler:
            self._say(
                f"The cluster at {export.scheduler} may have gone on with the export to "
                f"{export.output}: export again to follow it."
            )
            return
        place = replace(HERE, where=Where.CLUSTER, scheduler=export.scheduler, agreed=agreed)
        with reported(self._say):
            shot = read_shot(shot_of_job(export.output))
            self.run.export(shot, export.output, export.job, place)
            self._say(f"The cluster has gone on with the export to {export.output}.")

    @property
    def _left_as(self) -> str:
        return absolute(self._editing.shot.source or "")

    def close(self) -> None:
        """Stop an export and keep its finished frames, or leave it to the cluster that makes it."""
        left = self.run.close()
        if left is not None:
            now = self._preferences.now.left_exports
            self._preferences.change(left_exports={**now, self._left_as: left})
            save = self._preferences.saving()
            with reported(self._say):
                if save is not None:
                    save()
