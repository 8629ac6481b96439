"""Commands that change how the picture is viewed: zoom, exposure, overlays, comparison.

The reference is a picture file that the rendered picture is compared with.
"""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from heatlens.core.base.background import Background
from heatlens.core.base.faults import report_faults
from heatlens.core.base.messages import Worker
from heatlens.core.model.option import Values
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view.overlays import NO_OVERLAY
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import DIFFERENCE_GAINS, Against, Compare
from heatlens.core.model.view.view_geometry import zoom_view, zoom_view_to
from heatlens.media.plate.header.channel_choice import choose_color
from heatlens.media.plate.plate import FloatImage
from heatlens.media.plate.read import color_file_parts, read_color
from heatlens.render.gpu.context import check_plate_fits
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import new_texture, upload
from heatlens.studio.session.pictures.ruler import Ruler
from heatlens.studio.session.shared import Commands, Shared


@dataclass(frozen=True, eq=False)
class Reference:
    """The colors of a picture file, as side B of a comparison."""

    path: Path
    texture: Texture


@report_faults("The reference could not be read")
def read_reference(path: Path) -> tuple[Path, FloatImage]:
    """Return the path and the colors, (H, W, 4), of a picture file. Raise HeatlensError."""
    file_parts = color_file_parts(path, PlateOptions())
    choice = choose_color(path, [header for header, _ in file_parts], None)
    return path, read_color(path, file_parts, choice)[0]


class ReferenceLoader(Commands, Worker):
    """Reads a reference on a thread and keeps the latest one on the GPU."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.current: Reference | None = None
        self._ctx = shared.source.picture.renderer.ctx
        self._reader: Background[tuple[Path, FloatImage]] = Background(self._wake)

    def open(self, path: Path) -> None:
        """Begin to read a reference."""
        self._reader.start(partial(read_reference, path))

    def poll(self) -> None:
        """Put a new reference on the GPU and report it.

        Raise HeatlensError if it cannot be read; the previous one stays.
        """
        reference = self._reader.poll()
        if reference is None:
            return
        path, pixels = reference
        size = (pixels.shape[1], pixels.shape[0])
        check_plate_fits(self._ctx, *size)
        texture = new_texture(self._ctx, size, 4, label="reference")
        upload(texture, np.ascontiguousarray(pixels))
        if self.current is not None:
            self.current.texture.release()
        self.current = Reference(path, texture)
        self._notify(f"B is {path.name}.")


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

    def toggle_overlay(self, name: str) -> None:
        """Show the overlay of this name, or hide it if it is shown."""
        is_on = self._view.state.overlay == name
        self.change(overlay=NO_OVERLAY.name if is_on else name)

    def toggle_compare(self, compare: Compare) -> None:
        """Compare in this way, or stop if that is the current way."""
        is_on = self._view.state.compare is compare
        self.change(compare=Compare.OFF if is_on else compare)

    def leave_mode(self) -> bool:
        """Switch off the ruler, or leave the grid. Return True if either was in use."""
        if self.ruler.switch_off():
            return True
        is_grid = self._view.state.compare is Compare.GRID
        if is_grid:
            self.change(compare=Compare.OFF)
        return is_grid

    def toggle_ruler(self) -> None:
        """Switch the ruler on or off. It measures in a single picture, so leave a grid."""
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
        changes: Values = {field: not getattr(guides, field)}
        self.change(guides=replace(guides, **changes))

    def fit(self) -> None:
        """Show the whole picture."""
        self.change(zoom=None, center_px=None)

    def zoom(self, factor: float) -> None:
        """Zoom at the middle of the viewport."""
        view, shape = self._view, self._source.picture_shape(self._editing.shot)
        view.state = zoom_view(view.state, view.viewport, shape, factor, view.viewport.middle)

    def one_to_one(self) -> None:
        """Show one pixel of the picture on one pixel of the screen."""
        view, shape = self._view, self._source.picture_shape(self._editing.shot)
        view.state = zoom_view_to(view.state, view.viewport, shape, 1.0, view.viewport.middle)

    def expose(self, steps: int) -> None:
        """Change the exposure of the view by a number of quarter stops."""
        self._view.state = self._view.state.brighten(steps * _EXPOSURE_STEP)

    def reset_exposure_and_gamma(self) -> None:
        """Reset exposure and gamma of the view."""
        self.change(exposure_stops=0.0, gamma=1.0)

    def toggle_unit(self) -> None:
        """Switch the unit of distances between meters and feet."""
        self.change(unit="ft" if self._view.state.unit == "m" else "m")

    def step_gain(self, steps: int) -> None:
        """Amplify the difference picture more, or less if `steps` is negative."""
        current_gain = self._view.state.difference_gain
        nearest_gain = min(DIFFERENCE_GAINS, key=lambda gain: abs(gain - current_gain))
        index = DIFFERENCE_GAINS.index(nearest_gain) + steps
        index = min(max(index, 0), len(DIFFERENCE_GAINS) - 1)
        self.change(difference_gain=DIFFERENCE_GAINS[index])

    def swap_b(self) -> None:
        """Switch B between the reference and the pinhole picture, and notify the user."""
        is_reference = self._view.state.against is Against.REFERENCE
        new_side = Against.PINHOLE if is_reference else Against.REFERENCE
        if new_side is Against.REFERENCE and self._references.current is None:
            self._notify("No reference is loaded: open one with Ctrl+Shift+O.")
            return
        self.change(against=new_side)

    def compare_with(self, method: Method | None) -> None:
        """Compare with the pinhole picture (None) or with the same shot rendered by `method`."""
        current = self._view.state.compare
        compare = Compare.WIPE if current is Compare.OFF else current
        if method is None:
            self.change(against=Against.PINHOLE, compare=compare)
        else:
            self.change(against=Against.METHOD, b_method=method, compare=compare)
