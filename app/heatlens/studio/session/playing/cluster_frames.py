"""Let a cluster render the frames ahead, if exports are made by a cluster.

A worker of the cluster renders the whole picture at rest too, if that is chosen.
"""

from collections.abc import Container, Iterable, Iterator, Sequence
from itertools import islice

from heatlens.core.base.messages import Problem, passing_message
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.farm.export_place import ExportPlace, Where
from heatlens.deliver.farm.frame_cluster import FrameCluster
from heatlens.deliver.farm.frame_queue import FrameRequest, FrameResult
from heatlens.deliver.farm.render_workers import ON_THIS_MACHINE
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.resources import Texture
from heatlens.render.rendered_frames.cached_pictures import RenderedPicture
from heatlens.render.rendered_frames.frame_filler import FrameJob
from heatlens.render.rendered_frames.frame_store import FrameStore
from heatlens.studio.session.pictures.elsewhere import RemoteRenderer
from heatlens.studio.session.playing.ahead_jobs import AheadJobs, FramesRequest
from heatlens.studio.session.shared import Commands, Shared

_MAX_REQUESTED = 64  # frames that the workers may render before the window asks again


class ClusterFrames(Commands):
    """Requests missing frames from the workers of a cluster, and puts them into the store."""

    def __init__(self, shared: Shared, jobs: AheadJobs, store: FrameStore) -> None:
        super().__init__(shared)
        self._jobs, self._store = jobs, store
        self._cluster: FrameCluster | None = None
        self._reported_problem = ""
        self._sent_request: FramesRequest | None = None  # the last request that was sent
        self._failed_keys: set[str] = set()  # keys of frames that no worker could render
        self._whole_count = 0  # requested whole pictures so far

    @property
    def renders_ahead(self) -> bool:
        """True while workers render the frames ahead in place of this machine."""
        return self._export_place.ahead and self.has_workers

    @property
    def has_workers(self) -> bool:
        """True while there are workers that render for the window."""
        return self._cluster is not None and bool(self._cluster.status.workers)

    @property
    def _export_place(self) -> ExportPlace:
        return self._preferences.values.export_place

    @property
    def status_text(self) -> str:
        """How many workers render for the window, or why none does; "" without a cluster."""
        if self._cluster is None:
            return ""
        count = len(self._cluster.status.workers)
        worker_words = (
            f"{count} worker{'s' if count > 1 else ''} ready" if count else "connecting ..."
        )
        return self._cluster.status.problem or worker_words

    @property
    def awaits_consent(self) -> bool:
        """True while a scheduler answers that the user has not agreed to."""
        return self._cluster is not None and self._cluster.unconfirmed is not None

    def agree(self) -> None:
        """Use the scheduler that answers, now and as long as it is the same."""
        if self._cluster is not None and self.awaits_consent:
            self._preferences.change(cluster=self._cluster.confirm_scheduler())

    def local_jobs(self, jobs: Sequence[FrameJob]) -> Sequence[FrameJob]:
        """Return those of `jobs` that this machine has to render."""
        if not self.renders_ahead:
            return jobs
        return [] if self._jobs.program else [job for job in jobs if job.key in self._failed_keys]

    def poll(self, has_frames: bool) -> None:
        """Connect to the chosen cluster or leave it, and report its problems; once a frame.

        `has_frames` is True if there are frames to be rendered ahead.
        """
        export_place = self._export_place
        is_needed = (export_place.ahead and has_frames) or export_place.at_rest
        address = (
            export_place.scheduler if export_place.where is Where.CLUSTER and is_needed else ""
        )
        if self._cluster is not None and self._cluster.address != address:
            self.close()
        if address and self._cluster is None:
            agreed_scheduler = self._preferences.values.cluster
            self._cluster = FrameCluster(address, self._jobs.driver, self._wake, agreed_scheduler)
        self._jobs.program = (
            self._cluster.status.program if self._cluster and export_place.ahead else ()
        )
        self._say_once("" if self._cluster is None else self._cluster.status.problem)

    def _say_once(self, problem: str) -> None:
        """Show a problem when it begins, for as long as it lasts."""
        if problem != self._reported_problem:
            self._reported_problem = problem
            if problem:
                self._notify(passing_message(problem, lambda: self._reported_problem == problem))

    def store_arrived(self, keys: Container[str]) -> Iterator[str]:
        """Store arrived frames with one of these keys, and yield their keys; drop all others."""
        if self._cluster is None or not self._store.can_take_picture:
            return
        for answer in self._cluster.frames.collect_results():
            if answer.picture is not None and answer.key in keys:
                self._store.put(answer.key, answer.picture)
                yield answer.key
            elif answer.problem:
                self._failed_keys.add(answer.key)
                self._notify(Problem(f"{answer.problem} {ON_THIS_MACHINE}"))

    def request_frames(self, jobs: Iterable[FrameJob], request: FramesRequest | None) -> None:
        """Request these frames and cancel all others, once for each value of `request`."""
        if self._cluster is not None and not self.has_requested(request):
            self._sent_request = request
            wishes = (_wish_for(job) for job in jobs if job.key not in self._failed_keys)
            self._cluster.frames.request_frames(islice(wishes, _MAX_REQUESTED))

    def has_requested(self, request: FramesRequest | None) -> bool:
        """Return True if there is nothing more to request."""
        return (
            self._cluster is None or not self._export_place.ahead or request == self._sent_request
        )

    def keep_only(self, keys: Container[str]) -> None:
        """Cancel all requested frames but those with these keys."""
        if self._cluster is not None:
            self._sent_request = None
            self._cluster.frames.keep_requests(keys)

    # The whole picture at rest

    def request_whole(self, shot: Shot, frame: int) -> bool:
        """Request a picture at full precision; return False if this machine has to render it."""
        if not (self._export_place.at_rest and self.has_workers and self._cluster):
            return False
        make_job = self._jobs.whole_picture_job(shot, frame)
        if make_job is not None:
            self._whole_count += 1
            self._cluster.frames.request_urgent(
                FrameRequest(f"whole {self._whole_count}", make_job, is_kept=False)
            )
        return make_job is not None

    @property
    def is_whole_pending(self) -> bool:
        """True while workers render the whole picture."""
        return self.has_workers and self._cluster is not None and self.whole is None

    @property
    def whole(self) -> FrameResult | None:
        """The whole picture, or why no worker could render it; None until it arrives."""
        return None if self._cluster is None else self._cluster.frames.urgent_result

    def cancel_whole(self) -> None:
        """Cancel the request for the whole picture, if there is a cluster."""
        if self._cluster is not None:
            self._cluster.frames.request_urgent(None)

    def forget_failures(self) -> None:
        """Forget which frames no worker could render."""
        self._failed_keys.clear()

    def close(self) -> None:
        """Leave the cluster, without waiting for it."""
        if self._cluster is not None:
            self._cluster.close()
        self._cluster, self._sent_request = None, None
        self._failed_keys.clear()


def _wish_for(job: FrameJob) -> FrameRequest:
    """Return a job as a wish to the cluster."""
    return FrameRequest(job.key, lambda: job)


# A laptop without a GPU shows small pictures while something is dragged, and needs a long time for
# the whole one. A worker may render that, and it is canceled when the user goes on dragging.
# Previews are always rendered on this machine.
class WholePictures(RemoteRenderer):
    """Whole pictures of one renderer, from the workers of `cluster`."""

    def __init__(self, renderer: FrameRenderer, cluster: ClusterFrames) -> None:
        self._renderer, self._cluster = renderer, cluster
        self._is_requested = False

    @property
    def is_waiting(self) -> bool:
        return self._is_requested and self._cluster.is_whole_pending

    def steps(self, shot: Shot, frame: int, slot: int) -> Steps[Texture] | None:
        """Request the picture from a worker; return steps that wait for it, or None."""
        if shot.defocus.method.needs_scene or not self._cluster.request_whole(shot, frame):
            return None
        self._is_requested = True
        return self._wait_and_upload(shot, frame, slot)

    def cancel(self) -> None:
        """Cancel the request for a picture, if one is pending."""
        if self._is_requested:
            self._is_requested = False
            self._cluster.cancel_whole()

    def _wait_and_upload(self, shot: Shot, frame: int, slot: int) -> Steps[Texture]:
        """Wait, and upload the picture; if no worker can render it, render it here."""
        while self._cluster.is_whole_pending:
            yield "waiting for a worker"
        answer = self._cluster.whole
        self.cancel()
        picture = None if answer is None else answer.picture
        if isinstance(picture, RenderedPicture):
            return (yield from self._renderer.upload_steps(picture.pixels, slot))
        return (yield from self._renderer.steps(shot, frame, slot))
