"""The options of an export: the one list that the command, the Export tab and its job share.

The command line, the job that the window hands over, the rows of the Export tab and the palette
derive from these fields by their metadata; those without a label are not in the tab. Options of a
single run of the command, such as --progress, are in `fronts/commands/export_options.py`.
"""

from dataclasses import dataclass
from functools import partial
from typing import Literal

from heatlens.core.model.curves.frames import check_frames_per_second
from heatlens.core.model.option import option_field, options_of
from heatlens.deliver.export.burn_in import DEFAULT_TEMPLATE

FRAMES, EXR, LOOK = "frames", "EXR", "look"  # groups: options of all files, of EXR, of all others
USUAL_COMPRESSION = "zip"
AUTO_OVERSCAN = "auto"
_frames, _exr, _look = (
    partial(option_field, group=group, label="") for group in (FRAMES, EXR, LOOK)
)


@dataclass(frozen=True)
class PinholeOptions:
    """The options of a plate of a scene.

    overscan  pixels on every side; `AUTO_OVERSCAN` for as many as the lens needs; None for none
    deep      True to include the surfaces behind the picture
    """

    overscan: int | str | None = None
    deep: bool = False


@dataclass(frozen=True, kw_only=True)
class ExportOptions:
    """The user's choices for an export, apart from its shot, its files and the view."""

    frames: str = _frames(
        "",
        "frames",
        "1001-1100, 1001-1100x2, 1001,1005; default: in to out",
        metavar="RANGE",
        label="frames",
    )
    missing: Literal["hold", "black", "stop"] = _frames(
        "stop",
        "missing",
        "for a frame without a plate: hold the previous one, black, or stop before anything "
        "is rendered (default)",
    )
    force: bool = _frames(False, "force", "render finished frames again")
    overwrite: bool = _frames(
        False,
        "overwrite",
        "also replace files that no export of heatlens wrote; otherwise they stop the export",
        label="overwrite files not made by heatlens",
    )
    fps: float | None = _frames(
        None, "fps", "frame rate of a movie, and of a glTF (default: the shot's)", metavar="N"
    )
    start_timecode: str | None = _frames(
        None,
        "start timecode",
        "timecode of the first frame of the shot, plates or scene, in EXR headers, movies and the "
        "burn-in; HH:MM:SS;FF means drop-frame, for 29.97 and 59.94 (default: the shot's, else "
        "from the plates' headers)",
        metavar="HH:MM:SS:FF",
    )
    is_float: bool = _exr(False, "float", "32-bit float channels (default: half)")
    compression: Literal["none", "rle", "zips", "zip", "piz", "dwaa", "dwab"] = _exr(
        USUAL_COMPRESSION, "compression", "default zip"
    )
    with_depth: bool = _exr(
        False, "with depth", "Z in metres beside the colour", label="depth beside the colour"
    )
    with_coc: bool = _exr(False, "with coc", "circle of confusion in pixels beside the colour")
    keep_channels: str = _exr(
        "",
        "keep channels",
        "other layers and channels of the plate to copy unchanged into an EXR: names separated "
        "by commas, or all",
        metavar="NAMES",
    )
    burn_in: bool = _look(
        False,
        "burn in",
        "write frame, timecode and lens into the picture",
        label="burn in frame, timecode, lens",
    )
    burn_in_text: str = _look(
        DEFAULT_TEMPLATE,
        "burn in text",
        "text of the burn-in, with {frame} {timecode} {focus} {f_stop} {shot}; parts separated "
        f"by two spaces are left out if they are empty (default '{DEFAULT_TEMPLATE}')",
        metavar="TEXT",
        label="burn-in text",
    )
    shot_name: str = _look(
        "",
        "shot name",
        "{shot} in the burn-in (default: the name of the shot file)",
        metavar="NAME",
    )
    unit: Literal["m", "ft"] = _look(
        "m", "unit", "unit of the burn-in's distance, metres or feet (default m)"
    )

    def __post_init__(self) -> None:
        """Raise InputError for an impossible frame rate."""
        if self.fps is not None:
            check_frames_per_second(self.fps)


def options_of_group(group: str) -> tuple[str, ...]:
    """Return the names of the options in a group."""
    return tuple(name for name, it in options_of(ExportOptions).items() if it.group == group)


def options_in_panel(is_exr: bool) -> tuple[str, ...]:
    """Return the names of the options that the Export tab shows for a kind of file."""
    names = options_of_group(FRAMES) + options_of_group(EXR if is_exr else LOOK)
    return tuple(name for name in names if options_of(ExportOptions)[name].label)
