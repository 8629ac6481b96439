"""Commands that change how the picture is viewed: zoom, exposure, overlays, comparison."""

from dataclasses import replace
from typing import Any

from heatlens.model.option import Values
from heatlens.model.shot.settings import Method
from heatlens.model.view.view import DIFFERENCE_GAINS, Against, Compare, Overlay
from heatlens.model.view.view_geometry import zoomed, zoomed_to
from heatlens.session.pictures.picture_view import PictureView
from heatlens.session.pictures.reference import ReferenceLoader
from heatlens.session.pictures.ruler import Ruler
from heatlens.session.shared import Commands, Shared

_EXPOSURE_STEP = 0.25  # stops


class ViewCommands(Commands):
    """Changes of the view state; the shot stays unchanged."""

    def __init__(self, shared: Shared, view: PictureView, references: ReferenceLoader) -> None:
        super().__init__(shared)
        self._view = view
        self._references = references
        self.ruler = Ruler(shared, view)

    def change(self, **changes: Any) -> None:
        """Change these fields of the ViewState."""
        self._view.state = replace(self._view.state, **changes)

    def toggle(self, name: str) -> None:
        """Toggle a boolean field of the ViewState."""
        self.change(**{name: not getattr(self._view.state, name)})

    def toggle_overlay(self, overlay: Overlay) -> None:
        """Show an overlay, or hide it if it is shown."""
        is_on = self._view.state.overlay is overlay
        self.change(overlay=Overlay.NONE if is_on else overlay)

    def toggle_compare(self, compare: Compare) -> None:
        """Compare in this way, or stop if that is the current way."""
        is_on = self._view.state.compare is compare
        self.change(compare=Compare.OFF if is_on else compare)

    def leave(self) -> bool:
        """Put the ruler away or leave the grid. Return True if either was in use."""
        if self.ruler.leave():
            return True
        is_grid = self._view.state.compare is Compare.GRID
        if is_grid:
            self.change(compare=Compare.OFF)
        return is_grid

    def toggle_ruler(self) -> None:
        """Take the ruler or put it away. It measures in a single picture, not in a grid."""
        if self._view.state.compare is Compare.GRID:
            self.change(compare=Compare.OFF)
        self.ruler.toggle()

    def toggle_matte(self, aspect: float) -> None:
        """Toggle the matte that darkens what a picture of this aspect ratio would crop."""
        guides = self._view.state.guides
        self.change(guides=replace(guides, aspect=None if guides.aspect == aspect else aspect))

    def toggle_guide(self, field: str) -> None:
        """Draw or hide one kind of guide lines."""
        guides = self._view.state.guides
        changed: Values = {field: not getattr(guides, field)}
        self.change(guides=replace(guides, **changed))

    def fit(self) -> None:
        """Show the whole picture."""
        self.change(zoom=None, center_px=None)

    def zoom(self, factor: float) -> None:
        """Zoom at the middle of the viewport."""
        view, shape = self._view, self._source.picture_shape(self._editing.shot)
        view.state = zoomed(view.state, view.viewport, shape, factor, view.viewport.middle)

    def one_to_one(self) -> None:
        """Show one pixel of the picture on one pixel of the screen."""
        view, shape = self._view, self._source.picture_shape(self._editing.shot)
        view.state = zoomed_to(view.state, view.viewport, shape, 1.0, view.viewport.middle)

    def expose(self, steps: int) -> None:
        """Change the exposure of the view by a number of quarter stops."""
        stops = self._view.state.exposure_stops + steps * _EXPOSURE_STEP
        self.change(exposure_stops=stops)

    def reset_exposure_and_gamma(self) -> None:
        """Reset exposure and gamma of the view."""
        self.change(exposure_stops=0.0, gamma=1.0)

    def toggle_unit(self) -> None:
        """Switch the unit of distances between metres and feet."""
        self.change(unit="ft" if self._view.state.unit == "m" else "m")

    def step_gain(self, steps: int) -> None:
        """Amplify the difference picture more, or less if `steps` is negative."""
        now = self._view.state.difference_gain
        nearest = min(DIFFERENCE_GAINS, key=lambda gain: abs(gain - now))
        index = DIFFERENCE_GAINS.index(nearest) + steps
        index = min(max(index, 0), len(DIFFERENCE_GAINS) - 1)
        self.change(difference_gain=DIFFERENCE_GAINS[index])

    def swap_b(self) -> None:
        """Switch B between the reference and the pinhole picture."""
        is_reference = self._view.state.against is Against.REFERENCE
        other = Against.PINHOLE if is_reference else Against.REFERENCE
        if other is Against.REFERENCE and self._references.current is None:
            self._say("No reference is loaded: open one with Ctrl+Shift+O.")
            return
        self.change(against=other)

    def compare_with(self, method: Method | None) -> None:
        """Compare with the pinhole picture (None) or with the same shot rendered by `method`."""
        now = self._view.state.compare
        compare = Compare.WIPE if now is Compare.OFF else now
        if method is None:
            self.change(against=Against.PINHOLE, compare=compare)
        else:
            self.change(against=Against.METHOD, b_method=method, compare=compare)
