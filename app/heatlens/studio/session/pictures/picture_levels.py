"""Choose the quality of the next picture: while something is dragged, and at rest."""

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.render.defocus.other_methods import widest_px
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.preview.cost_model import CostModel
from heatlens.render.preview.level_choice import (
    first_picture_settings,
    is_better,
    level_at_rest,
    level_while_moving,
    useful_levels,
)
from heatlens.render.preview.shown import PictureKey
from heatlens.studio.session.pictures.elsewhere import ProcessBuilder

_MANY_PX = 1 << 20  # a larger picture may take long on a machine of which nothing is known yet


class PictureLevels:
    """Chooses levels by what pictures have cost so far, and by which programs are built."""

    def __init__(self, renderer: FrameRenderer, cost: CostModel, builder: ProcessBuilder) -> None:
        """Choose for the plate of `renderer`; `builder` builds programs instead of this process."""
        self._renderer, self._cost, self._builder = renderer, cost, builder
        # The version of the builder at which pictures with these settings needed a new program.
        self._refused_at: dict[DefocusSettings, int] = {}
        self.moving: DefocusSettings | None = None  # the level of the latest answer to a change

    # Before anything has been measured, the first picture is gathered: that needs one program and
    # is there after 0.2 s. Otherwise the driver of a new machine builds the programs of diffusion
    # first, 3.6 s of a processor for the quickest level of a 720p plate. The whole picture then
    # comes after 5.3 s instead of 9.5 s, because a small plate needs no levels in between.
    def while_moving(
        self, request: PictureKey, shown: DefocusSettings | None, budget_s: float
    ) -> DefocusSettings:
        """Return the best preview level that fits the time budget, see `level_while_moving`.

        `shown` are the settings of the shown picture; None before the first.
        """
        requested, size = request.settings, self._renderer.loaded.color.size
        useful = useful_levels(requested, size, self._renderer.has_many_views)
        levels = tuple(filter(self.is_buildable, useful))
        is_first = not self._cost.seconds_per_px and shown is None
        if is_first or not levels:
            return self._first_settings(request)
        if not self._cost.seconds_per_px:  # nothing has been measured on this machine yet
            return levels[-1]
        return level_while_moving(levels, self.moving, budget_s, self.predict_s)

    def _first_settings(self, request: PictureKey) -> DefocusSettings:
        """Return the settings of the first picture of a request."""
        optics = self._renderer.optics(request.shot, request.frame)
        size = self._renderer.loaded.color.size
        return first_picture_settings(request.settings, size, widest_px(optics))

    def at_rest(
        self,
        request: PictureKey,
        shown: DefocusSettings | None,
        budget_s: float,
        is_plate_whole: bool,
    ) -> DefocusSettings | None:
        """Return what to render at rest, see `level_at_rest`; None if `shown` is all there is."""
        requested = request.settings
        is_unknown = not self._cost.seconds_per_px and self.pixel_count(requested) > _MANY_PX
        if not is_unknown:
            level = level_at_rest(requested, shown, is_plate_whole, self.predict_s)
            if level is None or self.is_buildable(level):
                return level
            if is_plate_whole and self.is_buildable(requested):
                return requested
        level = self.while_moving(request, shown, budget_s)
        return level if shown is None or is_better(level, shown, requested) else None

    def note_refused(self, settings: DefocusSettings) -> None:
        """Note that a picture needs a program that another process has to build."""
        self._refused_at[settings] = self._builder.version

    def note_rendered(self, settings: DefocusSettings) -> None:
        """Note that a picture with these settings has all its programs."""
        self._refused_at.pop(settings, None)

    def is_buildable(self, settings: DefocusSettings) -> bool:
        """Return False while pictures with these settings wait for another process.

        What was never refused is tried: the process may be at work for another picture.
        """
        refused_at = self._refused_at.get(settings)
        is_new = refused_at == self._builder.version or self._builder.is_pending(settings)
        return refused_at is None or not is_new

    def predict_s(self, settings: DefocusSettings) -> float:
        """Return the predicted seconds for a picture with these settings."""
        return self._cost.predict_seconds(settings, self.pixel_count(settings))

    def pixel_count(self, settings: DefocusSettings) -> int:
        """Return the number of pixels at the proxy resolution of the settings."""
        width, height = proxy_size(self._renderer.loaded.color.size, settings.proxy)
        return width * height
