"""The interfaces for what other machines and processes do for the live picture."""

from contextlib import AbstractContextManager, nullcontext

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.resources import Texture


class RemoteRenderer:
    """Renders whole pictures in place of this machine; the base renders none."""

    @property
    def is_waiting(self) -> bool:
        """True while another machine renders a picture, and its steps have to wait."""
        return False

    def steps(self, shot: Shot, frame: int, slot: int) -> Steps[Texture] | None:
        """Return steps as `FrameRenderer.steps` does; None if this machine has to render."""
        return None

    def cancel(self) -> None:
        """Cancel the picture that is being rendered."""


class ProcessBuilder:
    """Builds programs in another process; the base builds none, and refuses none here."""

    version = 0  # increases when a picture that needed a new program may be tried again

    def is_pending(self, settings: DefocusSettings) -> bool:
        """Return True while pictures with these settings have to wait for the other process."""
        return False

    def refuse_new(self, shot: Shot) -> AbstractContextManager[None]:
        """Return a block in which NewProgramError is raised for each new program."""
        return nullcontext()

    def request(self, shot: Shot, frame: int) -> None:
        """Begin to build the programs of a shot, unless that is being done."""
