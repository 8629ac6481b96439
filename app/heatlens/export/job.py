"""What is exported, as a value: the same job gives the same files."""

from dataclasses import dataclass, field

from heatlens.color.view_transform import ViewTransform, srgb_transform
from heatlens.errors import InputError
from heatlens.export.output import Output
from heatlens.export.pinhole_plate import PinholeOptions
from heatlens.model.guides import NO_GUIDES, Guides
from heatlens.model.shot import Shot
from heatlens.sequence.sequence import MissingPolicy
from heatlens.source.named import checked_source

_STOPS_MOST = 30.0  # from there on all is white or black
_GAMMA_MOST = 10.0


@dataclass(frozen=True)
class ExrOptions:
    """How scene-linear frames are kept, and what else beside the colour."""

    half: bool = True
    compression: str = "zip"
    with_depth: bool = False  # Z, metres
    with_coc: bool = False  # coc, signed diameter in pixels of this picture
    keep: tuple[str, ...] = ()  # layers and channels of the plate, as in `kept_channels`


@dataclass(frozen=True)
class Look:
    """How pictures for the eye are made of light.

    Raises InputError for an exposure or gamma that no picture has.
    """

    transform: ViewTransform = field(default_factory=srgb_transform)
    exposure_stops: float = 0.0
    gamma: float = 1.0  # display values to the power of one over it
    burn_in: bool = False  # frame, focus and f-stop written into the picture
    unit: str = "m"  # of the distance in that
    guides: Guides = NO_GUIDES  # drawn into the picture

    def __post_init__(self) -> None:
        if not abs(self.exposure_stops) <= _STOPS_MOST:
            raise InputError(
                f"The exposure must be within {_STOPS_MOST:g} stops, got {self.exposure_stops:g}."
            )
        if not 1 / _GAMMA_MOST <= self.gamma <= _GAMMA_MOST:
            raise InputError(
                f"The gamma must be within 1/{_GAMMA_MOST:g} and {_GAMMA_MOST:g}, got "
                f"{self.gamma:g}."
            )


@dataclass(frozen=True)
class ExportJob:
    """`frames` of a shot to `output`. The look counts for pictures and movies, `exr` for EXR.

    missing  what stands in for a frame without a plate
    force    render also what is there already
    pinhole  the frames themselves, without a lens: a scene's, to be plates elsewhere
    beside   what those have beside the picture

    Raises InputError for no frame, and a shot of no plate.
    """

    shot: Shot
    frames: tuple[int, ...]
    output: Output
    missing: MissingPolicy = "stop"
    exr: ExrOptions = field(default_factory=ExrOptions)
    look: Look = field(default_factory=Look)
    force: bool = False
    pinhole: bool = False
    beside: PinholeOptions = field(default_factory=PinholeOptions)

    def __post_init__(self) -> None:
        checked_source(self.shot)
        if not self.frames:
            raise InputError("There is no frame to export. Give frames with --frames.")
        if self.pinhole and self.shot.defocus.proxy != 1.0:
            raise InputError("Frames without a lens are always full size: leave --proxy out.")
