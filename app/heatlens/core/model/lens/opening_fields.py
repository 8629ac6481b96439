"""The settings of a lens opening, and of where its focus leans: the only list of these fields.

`Aperture`, `Lens` and the `LensCharacter` of a kit inherit them. Camera files, the rows of the
panel, the command line and the arguments of Python derive from them by their metadata.
"""

from dataclasses import dataclass

from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import Values, option_field, options_of

BLADES_LEAST, BLADES_MOST = 3, 16
_ANGLE_RANGE: Values = {
    "metavar": "DEGREES",
    "least": -360.0,
    "most": 360.0,
    "slider": (-180.0, 180.0),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class OpeningFields:
    """The shape of the opening; round without arguments.

    `cat_eye` is the distance of the two circles of the barrel, as the corner of the picture sees
    them, in radii of the widest opening. An image replaces the blades, and their rotation turns it.
    Tilt and split do not change the opening, but the depths at which its discs are small
    (`core/model/focus/coc.py`). The `term` of their options names the field that is 0 without a
    tilt or a split.
    """

    squeeze: float = option_field(
        1.0,
        "squeeze",
        "anamorphic lens, 1 to 2: discs become S times as tall as wide (default 1)",
        metavar="S",
        least=1.0,
        most=2.0,
    )
    blades: int = option_field(
        0,
        "blades",
        "blades of the diaphragm, 3 to 16, with corners on the round opening; 0 (default) is round",
        metavar="N",
        least=0,
        most=BLADES_MOST,
    )
    blade_rotation_deg: float = option_field(
        0.0,
        "blade rotation",
        "degrees anticlockwise, as seen in lamps behind the focus; at 0 (default) a corner "
        "points up, and an aperture image is upright",
        metavar="DEGREES",
        least=-360.0,
        most=360.0,
        label="rotation",
        tip="Anticlockwise, as seen in lamps behind the focus. At 0 a corner points up.",
        slider=(-90.0, 90.0),
        shown="%.0f°",
    )
    blade_curvature: float = option_field(
        0.0,
        "blade curvature",
        "0 (default) for straight blades to 1 for a round opening",
        metavar="C",
        least=0.0,
        most=1.0,
        label="curvature",
        tip="0 straight, 1 round.",
    )
    cat_eye: float = option_field(
        0.0,
        "cat eye",
        "discs towards the corners are cut by the lens barrel, 0 (default) to 1; the cut "
        "decreases as the lens is stopped down from --widest-f-stop",
        metavar="C",
        least=0.0,
        most=1.0,
        label="cat's eye",
        tip="How far the barrel cuts the discs in the corners.",
    )
    rim: float = option_field(
        0.0,
        "rim",
        "rim of the discs behind the focus, -1 soft to 1 a bright ring (default 0, flat); in "
        "front of the focus it is reversed",
        metavar="R",
        least=-1.0,
        most=1.0,
        tip="Behind the focus: 1 a bright ring, -1 a soft one. In front the reverse.",
    )
    axial_colour_mm: float = option_field(
        0.0,
        "axial colour",
        "millimetres by which red focuses farther behind the lens than blue, as a lens test "
        "measures it (default 0)",
        metavar="MM",
        least=-5.0,
        most=5.0,
        tip="How much farther behind the lens red focuses than blue.",
        slider=(-1.0, 1.0),
        shown="%.2f mm",
    )
    aperture_image: OpeningImage | None = option_field(
        None,
        "aperture image",
        "a picture (PNG, JPEG, EXR, TIFF) in place of the blades: white lets light through, "
        "black blocks it; its square encloses the round opening; lamps behind the focus show "
        "it upright, those in front upside down",
        metavar="FILE",
        label="image",
        tip="A picture in place of the blades: white lets light through.",
    )

    tilt_deg: float = option_field(
        0.0,
        "tilt",
        "degrees by which the lens leans, as a tilt lens has them engraved: the plane of focus "
        "leans with it, about a line at focal length / sin(tilt) from the lens (default 0)",
        metavar="DEGREES",
        least=-20.0,
        most=20.0,
        tip="Degrees by which the lens leans. The plane of focus leans much more.",
        slider=(-10.0, 10.0),
        shown="%.1f°",
        term="tilt_deg",
    )
    tilt_direction_deg: float = option_field(
        0.0,
        "tilt direction",
        "where a tilted lens leans to, degrees anticlockwise in the picture: at 0 (default) down, "
        "so that the ground can be sharp, at 90 to the right",
        label="direction",
        tip="0 down, so that the ground can be sharp; 90 to the right, 180 up.",
        shown="%.0f°",
        term="tilt_deg",
        **_ANGLE_RANGE,
    )
    split_dioptres: float = option_field(
        0.0,
        "split dioptres",
        "strength of a split diopter, a close-up lens over a part of the picture, where the "
        "focus is nearer by so many 1/m (default 0: none)",
        metavar="D",
        least=-5.0,
        most=5.0,
        label="split diopter",
        tip="A close-up lens over a part of the picture: its strength in dioptres.",
        term="split_dioptres",
    )
    split_position: float = option_field(
        0.0,
        "split position",
        "distance of the split diopter's edge from the middle of the picture towards the glass, in "
        "halves of its width (default 0)",
        metavar="P",
        least=-1.0,
        most=1.0,
        label="edge at",
        tip="0 the middle of the picture, 1 half its width away, towards the glass.",
        term="split_dioptres",
    )
    split_direction_deg: float = option_field(
        0.0,
        "split direction",
        "where the glass of the split diopter lies, degrees anticlockwise in the picture: at 0 "
        "(default) on the right, at 90 above",
        label="glass towards",
        tip="0 on the right, 90 above, 180 on the left.",
        shown="%.0f°",
        term="split_dioptres",
        **_ANGLE_RANGE,
    )
    split_softness: float = option_field(
        0.05,
        "split softness",
        "width of the split diopter's edge, over which the focus goes from one distance to the "
        "other, in widths of the picture (default 0.05)",
        metavar="W",
        least=0.0,
        most=1.0,
        label="edge width",
        tip="The part of the picture's width over which the focus goes over.",
        term="split_dioptres",
    )

    @property
    def opening(self) -> Values:
        """The values of these fields by their names."""
        return {name: getattr(self, name) for name in options_of(OpeningFields)}
