"""The description of an export as a value: the same job gives the same files."""

import json
from dataclasses import dataclass, field, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import NO_GUIDES, Guides
from heatlens.core.model.view.view import DisplayOptions, check_exposure
from heatlens.deliver.export.options import ExportOptions, PinholeOptions
from heatlens.deliver.export.output import Output
from heatlens.media.color.view_transform import ViewTransform, srgb_transform
from heatlens.media.files.json_record import read_json, record_to_json
from heatlens.render.source.named import checked_source, has_camera


@dataclass(frozen=True)
class DisplaySettings:
    """How light becomes the display values of pictures and movies.

    Raises InputError if the exposure or the gamma is out of range.
    """

    transform: ViewTransform = field(default_factory=srgb_transform)
    exposure_stops: float = 0.0
    gamma: float = 1.0  # display values are raised to the power 1 / gamma
    guides: Guides = NO_GUIDES  # guides drawn into the picture

    def __post_init__(self) -> None:
        """Check the exposure and the gamma."""
        check_exposure(self.exposure_stops, self.gamma)


@dataclass(frozen=True)
class ExportJob:
    """Export `frames` of a shot to `output`; `display_settings` is for pictures and movies.

    keep             layers and channels of the plate to copy, see `kept_channels`
    pinhole          write the frames without a lens, as plates for other programs
    pinhole_options  overscan and depth format of these plates

    Raises InputError for no frames, and for a shot without a source.
    """

    shot: Shot
    frames: tuple[int, ...]
    output: Output
    options: ExportOptions = field(default_factory=ExportOptions)
    display_settings: DisplaySettings = field(default_factory=DisplaySettings)
    keep: tuple[str, ...] = ()
    pinhole: bool = False
    pinhole_options: PinholeOptions = field(default_factory=PinholeOptions)

    def __post_init__(self) -> None:
        checked_source(self.shot)
        if not self.frames:
            raise InputError("There is no frame to export. Give frames with --frames.")
        if self.pinhole and self.shot.defocus.proxy != 1.0:
            raise InputError("Frames without a lens are always full size: leave --proxy out.")


def blur_of_export(shot: Shot) -> DefocusSettings:
    """Return the blur settings of an export.

    The quality is final if the shot names neither a quality nor parts of the lens. 3D scenes, which
    have a camera, stay at film: they gain nothing from parts of the lens.
    """
    blur = shot.defocus
    is_unspecified = blur.quality is None and blur.parts == 1 and blur.method is Method.DIFFUSION
    return (
        replace(blur, quality=Quality.FINAL)
        if is_unspecified and not has_camera(shot.source)
        else blur
    )


_VERSION_KEY, _NEWEST_VERSION = "heatlens_export_job", 1
_KINDS: dict[str, type] = {"options": ExportOptions, "look": DisplayOptions, "guides": Guides}


def job_text(*records: ExportOptions | DisplayOptions | Guides) -> str:
    """Return records of options as the text of a file that `read_job` can read."""
    entries = {name: r for name, kind in _KINDS.items() for r in records if isinstance(r, kind)}
    records_json = {name: record_to_json(record) for name, record in entries.items()}
    return json.dumps({_VERSION_KEY: _NEWEST_VERSION, **records_json}, indent=2)


def read_job(path: Path) -> tuple[object, ...]:
    """Return the records of a file. Raises InputError that names the damaged place in it."""
    top = read_json(path)
    top.check_version(_VERSION_KEY, _NEWEST_VERSION, "export job")
    entries = top.members([_VERSION_KEY, *_KINDS])
    return tuple(entries[name].record(kind) for name, kind in _KINDS.items() if name in entries)
