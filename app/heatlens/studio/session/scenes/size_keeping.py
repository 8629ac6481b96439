"""Keep the size of the object on a mark while the lens is changed or the camera moves."""

import math
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import report_errors
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.same_size import KeptSize, crop_words
from heatlens.studio.session.shared import Commands, Shared

_ZOOM_MESSAGE = "Another focal length now zooms the picture."


class SizeKeeping(Commands):
    """Moves the camera with every change of the focal length, while a mark is chosen."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._renderer = self._source.picture.renderer
        self._chosen: str | None = None
        # The shot of a plate, and the focal length that was requested but cannot be reached.
        self._requested_length: tuple[Shot, float] | None = None

    @property
    def chosen(self) -> str | None:
        """Choose the mark whose size stays; None for none."""
        return self._chosen if self._chosen in self.names else None

    @chosen.setter
    def chosen(self, name: str | None) -> None:
        """Choose the mark whose size stays; None for none."""
        self._chosen, self._requested_length = name, None

    @property
    def names(self) -> list[str]:
        """The names of the marks to choose from."""
        return [mark.name for mark in self._editing.shot.marks]

    def switch(self) -> None:
        """Keep the size of the object on the mark nearest to the focus, or let the picture zoom."""
        marks = self._editing.shot.marks
        if self.chosen is not None or not marks:
            self.chosen = None
            self._notify(
                _ZOOM_MESSAGE if marks else "Set a mark first (M): what is on it keeps its size."
            )
            return
        self.chosen = min(marks, key=self._offset_dioptres).name
        self._notify(f"Changing the focal length now keeps {self.chosen} the same size.")

    def _offset_dioptres(self, mark: Mark) -> float:
        """Return how far a mark is from the focus in dioptres; infinity without a distance."""
        focus = 1 / self._editing.lens.focus_distance_m
        return abs(1 / mark.distance_m - focus) if isinstance(mark, DistanceMark) else math.inf

    @property
    def crop(self) -> float | None:
        """The share of a plate that the requested focal length would show; None without one."""
        if (
            self._requested_length is None
            or self._requested_length[0] != self._editing.shot
            or not self.chosen
        ):
            return None
        share = self._editing.lens.focal_length_mm / self._requested_length[1]
        return share if share < 1 else None

    def dolly_zoom(self, follower: Literal["camera", "length"]) -> None:
        """Let the camera follow the keyed focal length, or the focal length the camera."""
        with report_errors(self._notify):
            if self.chosen is None:
                raise InputError(
                    "Choose first what keeps its size: in the Lens tab, under the focal length."
                )
            kept_size = self._kept_size(self._editing.shot)
            self._editing.do(
                kept_size.follow_with_camera()
                if follower == "camera"
                else kept_size.follow_with_focal_length()
            )

    # A cinematographer compares 35 mm and 85 mm with the actor at the same size. The camera
    # therefore moves along its axis until the mark is as large as before; every change of the focal
    # length passes through here. A plate has no camera that could move: that is reported, and the
    # crop shows what would be seen.
    def reframe(self, old_shot: Shot, new_shot: Shot) -> Shot:
        """Return the changed shot with the camera moved so that the chosen mark keeps its size."""
        frame = self._editing.frame
        length_mm = new_shot.lens_at(frame).focal_length_mm
        if not self.chosen or length_mm == old_shot.lens_at(frame).focal_length_mm:
            return new_shot
        if not self._source.has_camera:
            self._requested_length = old_shot, length_mm
            raise InputError(crop_words(old_shot, frame, length_mm))
        return self._kept_size(old_shot).with_focal_length(length_mm)

    def _kept_size(self, shot: Shot) -> KeptSize:
        """Return the size of the chosen mark in a shot. Raise InputError without a scene."""
        scene, frame = self._renderer.scene, self._editing.frame
        if scene is None:
            raise InputError("No scene is open whose camera could move.")

        def depth_at(x: int, y: int) -> float:
            return self._renderer.scene_depth_m(shot, frame, x, y)

        mark = shot.mark_named(self.chosen)
        assert mark is not None
        return KeptSize(scene, shot, frame, mark, depth_at)
