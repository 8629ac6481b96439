"""The pinhole picture on the GPU: a plate of a file or a stream, or a drawn scene.

`SourceOnGpu` is the protocol through which the renderer uses every kind of source.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from heatlens.core.model.focus.coc import COC_MOST_PX, axial_px
from heatlens.core.model.focus.focus_offset import LEVEL
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.value_bins import ValueBins
from heatlens.media.plate.coc_line import focus_offset_in, line_of
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.scene import Scene
from heatlens.render.defocus.cutout_pass import CutoutTextures
from heatlens.render.defocus.focus_offset_survey import FocusOffsetSurvey
from heatlens.render.defocus.layer_cuts import gaps_of
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.resources import Texture
from heatlens.render.scene_gpu.overscan import Overscan
from heatlens.render.scene_gpu.peel import Peeled


@dataclass(frozen=True, eq=False)
class Pinhole:
    """One frame without a lens, as the defocus passes read it.

    color  RGBA, premultiplied
    depth  meters, or the signed circle of confusion in pixels if the plate holds that
    bins   the distribution of its depths, see `Plate.bins`
    fragments  the known surfaces behind the picture; None if there are none
    overscan   of a scene: the same picture with a margin; plates have theirs in their data window
    peeled     of a scene: the known surfaces behind the picture and its margin; None for a fast
               preview
    wide_pinhole  of a plate: the same with a margin that other frames showed, see `Plate.beyond`
    light_scale  the factor on `color` before the blur; the picture is divided by it
                 afterwards, and `fragments` and `cutout` are multiplied already
    cutout     of a plate: the part that a matte keeps sharp
    """

    plate: Plate
    color: Texture
    depth: Texture
    bins: ValueBins
    fragments: FragmentBuffers | None = None
    overscan: Overscan | None = None
    peeled: Peeled | None = None
    light_scale: float = 1.0
    wide_pinhole: "Pinhole | None" = None
    cutout: CutoutTextures | None = None


def pinhole_optics(focus_offsets: FocusOffsetSurvey, pinhole: Pinhole, lens: Lens) -> Optics:
    """Return the optics of a lens in front of a picture on the GPU, in pixels of its plate."""
    plate = pinhole.plate
    focus_offset = focus_offset_in(plate, lens) if plate.has_distances else LEVEL
    bins = focus_offsets.bins(pinhole.depth, pinhole.fragments, pinhole.bins, focus_offset)
    return optics_of(plate, bins, lens, None if focus_offset.is_level else bins)


def optics_of(
    plate: Plate, bins: ValueBins, lens: Lens, frame_bins: ValueBins | None = None
) -> Optics:
    """Return the optics of a lens in front of a plate, in pixels of its display window.

    `bins` are of all surfaces. `frame_bins` are of the surfaces that are visible in the frame; None
    for those of the plate. Both have the tilt of the focus subtracted, see `FocusOffsetSurvey`.
    """
    window, aspect = plate.display_window, plate.pixel_aspect_ratio
    offset = window.relative_to(plate.data_window).corner
    field = PictureField.of((window.width, window.height), aspect).moved(offset)
    disc = DiscShape(lens.aperture, aspect, field, axial_px(lens, window.width))
    if frame_bins is None:
        frame_bins = bins if plate.fragments is None else plate.visible_bins
    occupied_dioptres, gap_dioptres = bins.occupied, gaps_of(frame_bins)
    if plate.coc_px is not None:
        return Optics(
            line=None,
            occupied_px=occupied_dioptres,
            disc=disc,
            gaps_px=gap_dioptres,
            until=bins.occupied_shares,
        )
    line = line_of(plate, lens)
    coc, ends = (
        line.at_infinity_px + line.per_dioptre_px * dioptres
        for dioptres in (occupied_dioptres, gap_dioptres)
    )
    np.clip(coc, -COC_MOST_PX, COC_MOST_PX, out=coc)
    # In reverse order, because coc falls with diopters.
    until = 1.0 - bins.occupied_shares[::-1]
    return Optics(line, coc[::-1], disc, gaps_px=ends[::-1, ::-1], until=until)


class SourceOnGpu(Protocol):
    """A source on the GPU."""

    @property
    def scene(self) -> Scene | None:
        """The 3D scene; None for plates and streams."""

    @property
    def has_many_views(self) -> bool:
        """True if it can be seen from many points of the lens, by accumulation or ray tracing."""

    def size(self, shot: Shot) -> tuple[int, int]:
        """Return width and height of its picture in pixels. Raises InputError if it has none."""

    def check_method(self, method: Method) -> None:
        """Raise InputError for a method that needs more than this source has."""

    def pinhole_steps(
        self, shot: Shot, frame: int, views: int | None, is_for_file: bool = False
    ) -> Steps[Pinhole]:
        """Make the pinhole picture of `frame` in short steps, and return it.

        `views` is the number of samples per pixel of a scene; None accepts an existing picture with
        any number. With `is_for_file`, hidden surfaces are listed for the pixels of the picture;
        without, small pictures have finer ones. If steps are abandoned, the previous picture stays.
        """

    def through_lens(
        self, shot: Shot, frame: int, size: tuple[int, int], out: Texture
    ) -> Steps[None]:
        """Draw `frame` from many points of the lens at `size` into `out`, RGBA float32."""

    def pose_at(self, shot: Shot, frame: float) -> Pose | None:
        """Return the position and direction of the camera; None if only a picture is known."""

    def depth_m_at(self, shot: Shot, frame: float, x: int, y: int) -> float:
        """Return the distance in meters at a pixel of any frame, for a click to focus.

        Raises InputError outside the picture, and if only the loaded frame is known.
        """

    def set_step_size(self, share: float) -> None:
        """Set the work of each drawing step, as a share, 1 at most, of the usual work."""

    def share(self) -> "SourceOnGpu":
        """Return a source for other frames that shares the content on the GPU with this one.

        It is valid until this one is released. Raises InputError if there is nothing to share.
        """

    def release(self) -> None:
        """Free the memory on the GPU."""
