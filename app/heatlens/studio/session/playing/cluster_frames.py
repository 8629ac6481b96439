"""Have the frames ahead rendered by a cluster, if the place of exports is one.

The whole picture at rest is rendered by a worker too, if that is chosen.
"""

from collections.abc import Container, Iterable, Iterator, Sequence
from itertools import islice

from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.farm.frame_cluster import ON_THIS_MACHINE, Answer, FrameCluster, Wish
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Texture
from heatlens.render.rendered_frames.frame_filler import FrameJob
from heatlens.render.rendered_frames.frame_store import FrameStore
from heatlens.render.rendered_frames.kept_pictures import RenderedPicture
from heatlens.studio.session.messages import Problem, passing
from heatlens.studio.session.pictures.elsewhere import Elsewhere
from heatlens.studio.session.playing.pull_jobs import PullJobs, Wanted
from heatlens.studio.session.settings.export_place import ExportPlace, Where
from heatlens.studio.session.shared import Commands, Shared

_ASKED_MOST = 64  # frames that the workers may render before the window asks again


class ClusterFrames(Commands):
    """Asks workers for the frames that are missing, and puts them into the store."""

    def __init__(self, shared: Shared, jobs: PullJobs, store: FrameStore) -> None:
        super().__init__(shared)
        self._jobs, self._store = jobs, store
        self._cluster: FrameCluster | None = None
        self._said = ""
        self._asked: Wanted | None = None  # what frames were last asked for
        self._not_there: set[str] = set()  # keys of frames that no worker could render
        self._count = 0  # of whole pictures

    @property
    def is_at_work(self) -> bool:
        """Return True while workers render the frames ahead, so that this machine need not."""
        return self._place.ahead and self.has_workers

    @property
    def has_workers(self) -> bool:
        """Return True while there are workers that render for the window."""
        return self._cluster is not None and bool(self._cluster.workers)

    @property
    def _place(self) -> ExportPlace:
        return self._preferences.now.export_place

    @property
    def told(self) -> str:
        """How many workers render for the window, or why none does; "" without a cluster."""
        if self._cluster is None:
            return ""
        count = len(self._cluster.workers)
        at_work = f"{count} worker{'s' if count > 1 else ''} ready" if count else "connecting ..."
        return self._cluster.problem or at_work

    @property
    def asks(self) -> bool:
        """Return True while a scheduler answers to which the user has not agreed."""
        return self._cluster is not None and self._cluster.asks is not None

    def agree(self) -> None:
        """Use the scheduler that answers, now and as long as it is the same."""
        if self._cluster is not None and self.asks:
            self._preferences.change(cluster=self._cluster.agree())

    def left(self, jobs: Sequence[FrameJob]) -> Sequence[FrameJob]:
        """Return those of `jobs` that this machine has to render."""
        if not self.is_at_work:
            return jobs
        return [] if self._jobs.program else [it for it in jobs if it.key in self._not_there]

    def poll(self, has_frames: bool) -> None:
        """Connect to the chosen cluster or leave it, and report how it fares; once a frame.

        `has_frames` says that there are frames to be rendered ahead.
        """
        place = self._place
        is_of_use = (place.ahead and has_frames) or place.at_rest
        address = place.scheduler if place.where is Where.CLUSTER and is_of_use else ""
        if self._cluster is not None and self._cluster.address != address:
            self.close()
        if address and self._cluster is None:
            agreed = self._preferences.now.cluster
            self._cluster = FrameCluster(address, self._jobs.driver, self._wake, agreed)
        self._jobs.program = self._cluster.program if self._cluster and place.ahead else ()
        self._say_once("" if self._cluster is None else self._cluster.problem)

    def _say_once(self, problem: str) -> None:
        """Report a problem when it begins, for as long as it lasts."""
        if problem != self._said:
            self._said = problem
            if problem:
                self._say(passing(problem, lambda: self._said == problem))

    def arrived(self, keys: Container[str]) -> Iterator[str]:
        """Store the frames that have arrived, and yield their keys; others than `keys` are lost."""
        if self._cluster is None or not self._store.has_room:
            return
        for answer in self._cluster.taken():
            if answer.picture is not None and answer.key in keys:
                self._store.put(answer.key, answer.picture)
                yield answer.key
            elif answer.problem:
                self._not_there.add(answer.key)
                self._say(Problem(f"{answer.problem} {ON_THIS_MACHINE}"))

    def ask(self, jobs: Iterable[FrameJob], wanted: Wanted | None) -> None:
        """Ask for these frames and recall all others, once for each value of `wanted`."""
        if self._cluster is not None and not self.has_asked(wanted):
            self._asked = wanted
            left = (_wish(job) for job in jobs if job.key not in self._not_there)
            self._cluster.ask(islice(left, _ASKED_MOST))

    def has_asked(self, wanted: Wanted | None) -> bool:
        """Return True if there is nothing more to ask for."""
        return self._cluster is None or not self._place.ahead or wanted == self._asked

    def keep(self, keys: Container[str]) -> None:
        """Recall all frames but those with these keys."""
        if self._cluster is not None:
            self._asked = None
            self._cluster.keep(keys)

    # The whole picture at rest

    def ask_whole(self, shot: Shot, frame: int) -> bool:
        """Ask for a picture at full precision; return False if this machine has to render it."""
        if not (self._place.at_rest and self.has_workers and self._cluster):
            return False
        make = self._jobs.whole(shot, frame)
        if make is not None:
            self._count += 1
            self._cluster.ask_first(Wish(f"whole {self._count}", make, is_kept=False))
        return make is not None

    @property
    def is_coming(self) -> bool:
        """Return True while workers render the whole picture."""
        return self.has_workers and self._cluster is not None and self.whole is None

    @property
    def whole(self) -> Answer | None:
        """The whole picture, or why no worker could render it; None before it is there."""
        return None if self._cluster is None else self._cluster.first_answer

    def recall_whole(self) -> None:
        """Want the whole picture no more."""
        if self._cluster is not None:
            self._cluster.ask_first(None)

    def begin(self) -> None:
        """Forget what no worker could render."""
        self._not_there.clear()

    def close(self) -> None:
        """Leave the cluster, without waiting for it."""
        if self._cluster is not None:
            self._cluster.close()
        self._cluster, self._asked = None, None
        self._not_there.clear()


def _wish(job: FrameJob) -> Wish:
    return Wish(job.key, lambda: job)


# A laptop without a GPU shows small pictures while a hand moves, and then waited long for the whole
# one. That one may be asked of a worker, and is recalled when the hand moves again. Previews are
# always rendered here.
class WholePictures(Elsewhere):
    """Whole pictures of one renderer, from the workers of `cluster`."""

    def __init__(self, renderer: FrameRenderer, cluster: ClusterFrames) -> None:
        self._renderer, self._cluster = renderer, cluster
        self._is_asked = False

    @property
    def is_waiting(self) -> bool:
        return self._is_asked and self._cluster.is_coming

    def steps(self, shot: Shot, frame: int, slot: int) -> Steps[Texture] | None:
        if shot.defocus.method.needs_scene or not self._cluster.ask_whole(shot, frame):
            return None
        self._is_asked = True
        return self._steps(shot, frame, slot)

    def recall(self) -> None:
        if self._is_asked:
            self._is_asked = False
            self._cluster.recall_whole()

    def _steps(self, shot: Shot, frame: int, slot: int) -> Steps[Texture]:
        """Wait, and upload the picture; if no worker can render it, render it here."""
        while self._cluster.is_coming:
            yield "waiting for a worker"
        answer = self._cluster.whole
        self.recall()
        picture = None if answer is None else answer.picture
        if isinstance(picture, RenderedPicture):
            return (yield from self._renderer.uploading(picture.pixels, slot))
        return (yield from self._renderer.steps(shot, frame, slot))
