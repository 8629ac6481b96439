"""The interface for whole pictures that another machine renders."""

from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.device import Texture


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
