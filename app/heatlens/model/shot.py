"""What is rendered: a lens over frames and how its blur is computed."""

from dataclasses import dataclass, field

from heatlens.model.lens import Lens
from heatlens.model.settings import DefocusSettings


@dataclass(frozen=True, slots=True)
class Shot:
    """A shot is a value: the same shot and frame give the same picture."""

    lens: Lens
    defocus: DefocusSettings = field(default_factory=DefocusSettings)

    def lens_at(self, frame: int) -> Lens:
        """The lens at a frame; it stands still."""
        return self.lens
