"""The options of the view transform: how light becomes display values."""

from dataclasses import dataclass

from heatlens.model.option import option_field

PLAIN_VIEW = "sRGB curve"
NO_GRADE = "none"


@dataclass(frozen=True)
class DisplayOptions:
    """The view of an OpenColorIO config that pictures and movies are made with.

    ocio            path or name of the config; None: $OCIO, else a built-in one
    display, view   names in the config; None: its defaults
    input_space     name of the colour space of the light; None: from the plate's header
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
