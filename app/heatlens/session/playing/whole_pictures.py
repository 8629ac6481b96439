"""Have the whole picture at rest rendered by a worker of a cluster, if that is chosen."""

import moderngl

from heatlens.defocus.steps import Steps
from heatlens.model.shot.shot import Shot
from heatlens.render import FrameRenderer
from heatlens.rendered_frames.kept_picture import RenderedPicture
from heatlens.session.pictures.elsewhere import Elsewhere
from heatlens.session.playing.cluster_frames import ClusterFrames


class WholePictures(Elsewhere):
    """Whole pictures of one renderer, from the workers of `cluster`."""

    def __init__(self, renderer: FrameRenderer, cluster: ClusterFrames) -> None:
        self._renderer, self._cluster = renderer, cluster
        self._is_asked = False

    @property
    def is_waiting(self) -> bool:
        return self._is_asked and self._cluster.is_coming

    def steps(self, shot: Shot, frame: int, slot: int) -> Steps[moderngl.Texture] | None:
        if shot.defocus.method.needs_scene or not self._cluster.ask_whole(shot, frame):
            return None
        self._is_asked = True
        return self._steps(shot, frame, slot)

    def recall(self) -> None:
        if self._is_asked:
            self._is_asked = False
            self._cluster.recall_whole()

    def _steps(self, shot: Shot, frame: int, slot: int) -> Steps[moderngl.Texture]:
        """Wait, and upload the picture; if no worker can render it, render it here."""
        while self._cluster.is_coming:
            yield "waiting for a worker"
        answer = self._cluster.whole
        self.recall()
        found = None if answer is None else answer.picture
        if isinstance(found, RenderedPicture):
            return (yield from self._renderer.uploading(found.pixels, slot))
        return (yield from self._renderer.steps(shot, frame, slot))
