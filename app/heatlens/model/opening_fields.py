"""The settings of a lens opening: the only list of these fields.

`Aperture`, `Lens` and the `LensCharacter` of a kit inherit them. Camera files, the rows of the
panel, the command line and the arguments of Python derive from them by their metadata.
"""

from dataclasses import dataclass

from heatlens.model.opening_image import OpeningImage
from heatlens.model.option import Values, option_field, options_of

BLADES_LEAST, BLADES_MOST = 3, 16


@dataclass(frozen=True, slots=True, kw_only=True)
class OpeningFields:
    """The shape of the opening; round without arguments.

    `cat_eye` is the distance of the two circles of the barrel, as the corner of the picture sees
    them, in radii of the widest opening. An image replaces the blades, and their rotation turns it.
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

    @property
    def opening(self) -> Values:
        """The values of these fields by their names."""
        return {name: getattr(self, name) for name in options_of(OpeningFields)}
