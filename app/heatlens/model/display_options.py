"""The options of the view transform: how light becomes display values."""

from dataclasses import dataclass, field

from heatlens.model.option import option

PLAIN_VIEW = "sRGB curve"


@dataclass(frozen=True)
class DisplayOptions:
    """The view of an OpenColorIO config that pictures and movies are made with.

    ocio            path or name of the config; None: $OCIO, else a built-in one
    display, view   names in the config; None: its defaults
    input_space     name of the colour space of the light; None: from the plate's header
    gamma           display values are raised to 1/gamma, after the view
    exposure_stops  brighter by 2^stops, before the view
    """

    ocio: str | None = field(
        default=None,
        metadata=option(
            "ocio", "OpenColorIO config (default: $OCIO, else a built-in one)", metavar="CONFIG"
        ),
    )
    display: str | None = field(
        default=None,
        metadata=option("display", "default: the config's first", metavar="NAME"),
    )
    view: str | None = field(
        default=None,
        metadata=option(
            "view",
            f"default: the display's first; '{PLAIN_VIEW}' is the plain one",
            metavar="NAME",
        ),
    )
    input_space: str | None = field(
        default=None,
        metadata=option(
            "input space",
            "colour space of the plate (default: from its header, else linear Rec.709)",
            metavar="NAME",
        ),
    )
    gamma: float = field(
        default=1.0,
        metadata=option("gamma", "applied after the view (default 1)", metavar="G"),
    )
    exposure_stops: float = field(
        default=0.0,
        metadata=option(
            "exposure", "exposure in stops, positive is brighter (default 0)", metavar="STOPS"
        ),
    )
