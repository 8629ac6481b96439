"""The view of a picture, as opposed to its content, and how light becomes display values."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Literal, get_args

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import check_range, option_field
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view.guides import NO_GUIDES, USUAL_PEAKING, Guides, Peaking
from heatlens.core.model.view.overlays import NO_OVERLAY, overlay_of


class Compare(StrEnum):
    """How A, the picture through the lens, is compared with B."""

    OFF = "off"
    WIPE = "wipe"  # A left of the handle, B right of it
    FLIP = "flip"  # B alone
    DIFFERENCE = "difference"  # |A - B| times the gain
    GRID = "grid"  # up to four looks beside each other


class Against(StrEnum):
    """The kinds of picture that B can be."""

    PINHOLE = "pinhole"
    REFERENCE = "reference"  # any EXR that was loaded for it
    METHOD = "method"  # the same shot, its blur computed in another way
    LOOK = "look"  # the same frame through the lens of a look
    CHANNEL = "channel"  # any channel of the plate's file
    SHOT = "shot"  # the same frame with the lens, the keys and the blur of another shot


GRID_MOST = 4  # looks beside each other
DIFFERENCE_GAINS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # steps of the keys
GAIN_LEAST, GAIN_MOST = 0.5, 64.0
ZOOM_LEAST, ZOOM_MOST = 1 / 64, 256.0  # pixels of the screen for one of the picture
STOPS_MOST = 30.0  # of exposure: beyond this, everything is white or black
_GAMMA_MOST = 10.0
_CENTER_MOST_PX = 1e12  # of the middle of the viewport, beyond any zoom into a corner
DistanceUnit = Literal["m", "ft"]


def check_exposure(exposure_stops: float, gamma: float) -> None:
    """Raise InputError if the exposure or the gamma of a view is out of range."""
    if not abs(exposure_stops) <= STOPS_MOST:
        raise InputError(
            f"The exposure must be within {STOPS_MOST:g} stops, got {exposure_stops:g}."
        )
    if not 1 / _GAMMA_MOST <= gamma <= _GAMMA_MOST:
        raise InputError(
            f"The gamma must be within 1/{_GAMMA_MOST:g} and {_GAMMA_MOST:g}, got {gamma:g}."
        )


@dataclass(frozen=True, slots=True)
class ViewState:
    """Viewer state: not saved in the shot, not undoable. Raises InputError out of its ranges.

    zoom             pixels of the screen for one of the picture, None: the picture fits
    center_px        point of the display window that lies in the middle of the viewport, None: its
                     own middle
    depth_of_field   False shows the pinhole picture
    overlay          name of what is drawn over the picture, see `model.view.overlays`
    b_method         how B's blur is computed where B is a method
    b_look           name of the look if B is a look
    channel          what of the plate's file B shows where it is a channel
    a_look           name of A's look if B is a look; "" for the current lens
    grid             names of the looks in the grid, () for the first ones
    wipe             position of the handle, from 0 at the left of the picture to 1 at the right
    exposure_stops   brighter by 2^stops before the view transform
    gamma            display values to the power of 1/gamma, after it
    display, view    names in the color config; "" its defaults
    input_space      name of the color space of the pictures; "" for that of their header
    unit             distances in "m" or "ft"
    pixel_grid       lines between pixels where they are large
    pixel_values     the light of each pixel written into it where they are larger still
    is_peaking       color what is in focus, over any overlay
    peaking          how what is in focus is colored
    guides           lines and mattes over the picture
    is_graded        the grade of the shot is applied before the view transform
    loupe            show the pinhole picture under the pointer, larger, and what a click would pick
    """

    zoom: float | None = None
    center_px: tuple[float, float] | None = None
    depth_of_field: bool = True
    overlay: str = NO_OVERLAY.name
    compare: Compare = Compare.OFF
    against: Against = Against.PINHOLE
    b_method: Method = Method.GATHER
    b_look: str = ""
    channel: str = ""
    a_look: str = ""
    grid: tuple[str, ...] = ()
    wipe: float = 0.5
    difference_gain: float = 4.0
    exposure_stops: float = 0.0
    gamma: float = 1.0
    display: str = ""
    view: str = ""
    input_space: str = ""
    unit: DistanceUnit = "m"
    pixel_grid: bool = True
    pixel_values: bool = True
    is_peaking: bool = False
    peaking: Peaking = USUAL_PEAKING
    guides: Guides = NO_GUIDES
    is_graded: bool = True
    loupe: bool = False

    def __post_init__(self) -> None:
        """Check the values, whoever sets them: a page, the command line or a panel."""
        check_exposure(self.exposure_stops, self.gamma)
        overlay_of(self.overlay)
        check_range("zoom", self.zoom, ZOOM_LEAST, ZOOM_MOST)
        check_range("place of the handle", self.wipe, 0.0, 1.0)
        check_range("gain", self.difference_gain, GAIN_LEAST, GAIN_MOST)
        for coordinate in self.center_px or ():
            check_range("place in the middle", coordinate, -_CENTER_MOST_PX, _CENTER_MOST_PX)
        if self.unit not in get_args(DistanceUnit):
            raise InputError(f"The unit of distances should be m or ft, got {self.unit!r}.")

    @property
    def has_overlay(self) -> bool:
        """True if colors are laid over the picture: an overlay, peaking or both."""
        return self.overlay != NO_OVERLAY.name or self.is_peaking

    def with_transmission(self, lens: Lens) -> "ViewState":
        """Return the view with its exposure reduced by the transmission of a lens (T-stop)."""
        return self.brighten(lens.transmission_stops)

    def brighten(self, stops: float) -> "ViewState":
        """Return the view brighter by `stops`, within the range of an exposure."""
        exposure = self.exposure_stops + stops
        return replace(self, exposure_stops=min(max(exposure, -STOPS_MOST), STOPS_MOST))


PLAIN_VIEW = "sRGB curve"  # the name of the view without OpenColorIO
NO_GRADE = "none"  # the name of a grade that stands for no grade at all


@dataclass(frozen=True)
class DisplayOptions:
    """The view of an OpenColorIO config that pictures and movies are made with.

    Raises InputError if the exposure or the gamma is out of range.

    ocio            path or name of the config; None: $OCIO, else a built-in one
    display, view   names in the config; None: its defaults
    input_space     name of the color space of the light; None: from the plate's header
    gamma           display values are raised to 1/gamma, after the view
    exposure_stops  brighter by 2^stops, before the view
    cdl             name of a grade, see `color.grade_file`; "none"; None: that of the shot
    """

    ocio: str | None = option_field(
        None, "ocio", "OpenColorIO config (default: $OCIO, else a built-in one)", metavar="CONFIG"
    )
    display: str | None = option_field(
        None, "display", "default: the config's first", metavar="NAME"
    )
    view: str | None = option_field(
        None,
        "view",
        f"default: the display's first; '{PLAIN_VIEW}' is the plain one",
        metavar="NAME",
    )
    input_space: str | None = option_field(
        None,
        "input space",
        "colour space of the plate (default: from its header, else linear Rec.709)",
        metavar="NAME",
    )
    gamma: float = option_field(1.0, "gamma", "applied after the view (default 1)", metavar="G")
    exposure_stops: float = option_field(
        0.0, "exposure", "exposure in stops, positive is brighter (default 0)", metavar="STOPS"
    )
    cdl: str | None = option_field(
        None,
        "cdl",
        "grade (ASC CDL) before the view, in the config's role color_timing: a .cc, .ccc or .cdl "
        "file, FILE#ID, 'SLOPE OFFSET POWER SATURATION', or none (default: that of the shot)",
        metavar="GRADE",
    )

    def __post_init__(self) -> None:
        """Check the exposure and the gamma."""
        check_exposure(self.exposure_stops, self.gamma)
