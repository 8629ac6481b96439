"""Blur a pinhole picture through a lens, with what is known around its frame."""

from collections.abc import Callable
from dataclasses import dataclass

from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.media.plate.coc_line import focus_offset_in
from heatlens.render.defocus.focus_offset_survey import FocusOffsetSurvey
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.pipeline import DefocusPipeline
from heatlens.render.defocus.quality import layers_for
from heatlens.render.defocus.reduced_plate import PlateTextures
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.resources import Texture
from heatlens.render.scene_gpu.overscan import Overscan
from heatlens.render.scene_gpu.peel import Peeled
from heatlens.render.source.pinhole import Pinhole, optics_of, pinhole_optics


# The border around a frame is blurred with the frame and then cropped off, because a lens blurs
# what lies outside the frame into it. A source knows its border if a scene was drawn with it or if
# other frames show it. Elsewhere the solver repeats the last pixel of each line without end, which
# costs nothing; a line that ends in an insulator would mirror the picture. Repeating the last pixel
# took the mean FLIP over eleven lenses from .0452 to .0445, and beside a wide blur at a border from
# .0400 to .0364.
@dataclass(frozen=True, eq=False)
class PlateBlur:
    """Blurs pinhole pictures through a lens, in the textures of a pipeline.

    check_fits  raises GpuError for a picture of a size that this machine cannot blur
    enlarges    a small picture may be enlarged, so that its highlights are round
    """

    passes: DefocusPasses
    focus_offsets: FocusOffsetSurvey
    pipeline: DefocusPipeline
    lens: Lens
    settings: DefocusSettings
    check_fits: Callable[[tuple[int, int]], None]
    enlarges: bool = False

    def steps(self, pinhole: Pinhole) -> Steps[Texture]:
        """Blur a picture with the border that is known, and return its frame."""
        is_whole = self.settings.proxy == 1.0
        if is_whole and pinhole.overscan is not None:
            return (yield from self._blur_with_overscan(pinhole, pinhole.overscan))
        if is_whole and pinhole.wide_pinhole is not None:
            return (yield from self._blur_with_border(pinhole, pinhole.wide_pinhole))
        return (yield from self._blur_picture(pinhole))

    def _blur_picture(self, pinhole: Pinhole) -> Steps[Texture]:
        """Blur a picture without its border.

        For the blur, its light is scaled so that a white surface is about 1.
        """
        color, scale, scratch = pinhole.color, pinhole.light_scale, self.pipeline.scratch
        if scale != 1.0 and pinhole.cutout is None:
            color = scratch.texture("scaled colour", color.size, 4)
            self.passes.crop.run(pinhole.color, (0, 0), color, light_scale=scale)
        textures = PlateTextures(color, pinhole.depth, pinhole.fragments, cutout=pinhole.cutout)
        optics = pinhole_optics(self.focus_offsets, pinhole, self.lens)
        has_alpha = pinhole.plate.has_alpha
        picture = yield from self.pipeline.steps(
            textures, optics, self.settings, has_alpha, self.enlarges
        )
        if scale == 1.0:
            return picture
        out = scratch.texture("in plate's light", picture.size, 4)
        self.passes.crop.run(picture, (0, 0), out, light_scale=1.0 / scale)
        return out

    def _blur_with_border(self, pinhole: Pinhole, wide: Pinhole) -> Steps[Texture]:
        """Blur a plate with the border that other frames showed, and return the frame."""
        self.check_fits(wide.color.size)
        picture = yield from self._blur_picture(wide)
        frame = pinhole.plate.data_window.relative_to(wide.plate.data_window)
        out = self.pipeline.scratch.texture("frame of a plate", pinhole.color.size, 4)
        self.passes.crop.run(picture, frame.corner, out)
        return out

    def _blur_with_overscan(self, pinhole: Pinhole, overscan: Overscan) -> Steps[Texture]:
        """Blur a scene with as much of its margin as reaches the frame, and return the frame."""
        if self.settings.quality in (Quality.DRAFT, Quality.PREVIEW):
            overscan = overscan.in_picture_pixels  # a preview has to come soon
        is_listed = layers_for(self.settings) > 1 and overscan is pinhole.overscan
        peeled = pinhole.peeled if is_listed else None
        optics = self._optics_around(pinhole, overscan, peeled)
        margin, fine = overscan.used_px(optics), overscan.fine
        textures = yield from self._crop_to_box(overscan, peeled, overscan.box_with_margin(margin))
        wide = optics.moved((margin, margin)).scaled(fine)
        has_alpha = pinhole.plate.has_alpha
        picture = yield from self.pipeline.steps(textures, wide, self.settings, has_alpha)
        out = self.pipeline.scratch.texture("frame", pinhole.color.size, 4)
        self.passes.crop.run(picture, (fine * margin,) * 2, out, fine)
        return out

    def _optics_around(self, pinhole: Pinhole, overscan: Overscan, peeled: Peeled | None) -> Optics:
        """Return the optics for the frame with its whole margin and the surfaces behind it."""
        plate, lens, surfaces = pinhole.plate, self.lens, peeled or overscan
        focus_offset = (
            focus_offset_in(plate, lens).moved((overscan.margin_px,) * 2).scaled(overscan.fine)
        )
        behind = None if peeled is None else peeled.fragments
        bins = self.focus_offsets.bins(surfaces.depth, behind, surfaces.bins, focus_offset)
        return optics_of(plate, bins, lens, pinhole.bins if focus_offset.is_level else bins)

    def _crop_to_box(
        self, overscan: Overscan, peeled: Peeled | None, box: Box
    ) -> Steps[PlateTextures]:
        """Copy out the part of an overscanned picture that can blur into the frame.

        `box` is that part in the pixels of the overscan. The yielded name is that of the pass whose
        time includes this.
        """
        size, scratch, crop = (box.width, box.height), self.pipeline.scratch, self.passes.crop
        self.check_fits(size)
        color = scratch.texture("wide colour", size, 4)
        depth = scratch.texture("wide depth", size, 1)
        for whole, out in ((overscan.color, color), ((peeled or overscan).depth, depth)):
            crop.run(whole, (box.x0, box.y0), out)
            yield "coc"
        if peeled is None:
            return PlateTextures(color, depth)
        positions = scratch.texture("wide positions", size, 4)
        crop.run(peeled.positions, (box.x0, box.y0), positions)
        return PlateTextures(color, depth, peeled.fragments.crop(box), positions)
