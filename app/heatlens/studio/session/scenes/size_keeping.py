"""Keep the size of what is on a mark while the lens is changed or the camera moves."""

import math
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.same_size import KeptSize, crop_words
from heatlens.studio.session.messages import reported
from heatlens.studio.session.shared import Commands, Shared

_ZOOMS = "Another focal length now zooms the picture."


class SizeKeeping(Commands):
    """Every change of the focal length moves the camera, while a mark is chosen."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._renderer = self._source.picture.renderer
        self._chosen: str | None = None
        self._asked: tuple[Shot, float] | None = None  # of a plate: another length, in vain
        self._editing.reframed = self._reframed

    @property
    def chosen(self) -> str | None:
        """The name of the mark; None while the picture zooms."""
        return self._chosen if self._chosen in self.names else None

    @chosen.setter
    def chosen(self, name: str | None) -> None:
        self._chosen, self._asked = name, None

    @property
    def names(self) -> list[str]:
        """The names of the marks to choose from."""
        return [mark.name for mark in self._editing.shot.marks]

    def switch(self) -> None:
        """Keep the size of what is on the mark nearest to the focus, or let the picture zoom."""
        marks = self._editing.shot.marks
        if self.chosen is not None or not marks:
            self.chosen = None
            self._say(_ZOOMS if marks else "Set a mark first (M): what is on it keeps its size.")
            return
        self.chosen = min(marks, key=self._off).name
        self._say(f"Every other focal length now keeps the size of {self.chosen}.")

    def _off(self, mark: Mark) -> float:
        """Return the dioptres of a mark from the focus; those without a distance are last."""
        focus = 1 / self._editing.lens.focus_distance_m
        return abs(1 / mark.distance_m - focus) if isinstance(mark, DistanceMark) else math.inf

    @property
    def crop(self) -> float | None:
        """The share of a plate that the focal length shows that was asked for; None without."""
        if self._asked is None or self._asked[0] != self._editing.shot or not self.chosen:
            return None
        share = self._editing.lens.focal_length_mm / self._asked[1]
        return share if share < 1 else None

    def dolly_zoom(self, by: Literal["camera", "length"]) -> None:
        """Let the camera follow the keyed focal length, or the focal length the camera."""
        with reported(self._say):
            if self.chosen is None:
                raise InputError("Choose what keeps its size first, under the focal length.")
            kept = self._kept(self._editing.shot)
            self._editing.do(kept.by_camera() if by == "camera" else kept.by_length())

    # The first question of a cinematographer in a scene is what 85 mm instead of 35 mm look like
    # with A as large as before. The camera therefore goes along its axis until it is, and every
    # change of the focal length passes through here. A plate has no camera that could go; it says
    # so, and frames what would be seen.
    def _reframed(self, before: Shot, after: Shot) -> Shot:
        """Return the shot after a change of the lens, from where the chosen thing is as large."""
        frame = self._editing.frame
        length_mm = after.lens_at(frame).focal_length_mm
        if not self.chosen or length_mm == before.lens_at(frame).focal_length_mm:
            return after
        if not self._source.has_camera:
            self._asked = before, length_mm
            raise InputError(crop_words(before, frame, length_mm))
        return self._kept(before).at_length(length_mm)

    def _kept(self, shot: Shot) -> KeptSize:
        scene, frame = self._renderer.scene, self._editing.frame
        if scene is None:
            raise InputError("No scene is open whose camera could move.")

        def depth_at(x: int, y: int) -> float:
            return self._renderer.scene_depth_m(shot, frame, x, y)

        mark = shot.mark_named(self.chosen)
        assert mark is not None
        return KeptSize(scene, shot, frame, mark, depth_at)
