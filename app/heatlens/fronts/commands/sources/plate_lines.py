"""List what is known about a plate for `heatlens info`."""

from heatlens.core.model.lens.lens import LensModel
from heatlens.fronts.commands.output.thing_words import thing_lines
from heatlens.fronts.commands.sources.source_commands import Facts, Line
from heatlens.media.color.color_config import PLAIN_OCIO_VIEW

_CAMERA_LINES = (
    ("focal length", "focal_length_mm", "mm"),
    ("f-stop", "f_stop", ""),
    ("T-stop", "t_stop", ""),
    ("focus distance", "focus_distance_m", "m"),
    ("sensor width", "sensor_width_mm", "mm"),
    ("sensor height", "sensor_height_mm", "mm"),
    ("lens model", "model", ""),
)
_DISPLAY_REFERRED_VIEW = (
    f"{PLAIN_OCIO_VIEW}, if the config has it, unless --view is given: the picture is "
    "display-referred, and its tones are mapped already"
)


def plate_lines(facts: Facts) -> list[Line]:
    """Return the facts of `inspect` as text, each with a label."""
    return [
        ("file", facts["path"]),
        ("size", f"{facts['width_px']} x {facts['height_px']} px"),
        ("data window", _window_text(facts["data_window"])),
        ("display window", _window_text(facts["display_window"])),
        ("pixel aspect", f"{facts['pixel_aspect_ratio']:g}"),
        *([("views", ", ".join(facts["views"]))] if facts["views"] else []),
        *_part_lines(facts["parts"]),
        *thing_lines(facts["things"]),
        *_camera_lines(facts["camera"]),
        *_primaries_lines(facts["primaries"]),
        *([("seen through", _DISPLAY_REFERRED_VIEW)] if facts["is_for_the_eye"] else []),
        *_color_lines(facts["color"]),
        *_depth_lines(facts["depth"]),
        *_behind_lines(facts["behind"]),
        *(("note", note) for note in facts["notes"]),
    ]


def _window_text(corners: list[int]) -> str:
    """Format the first and the last pixel of a window, as other EXR tools do."""
    x0, y0, x1, y1 = corners
    return f"({x0}, {y0}) to ({x1 - 1}, {y1 - 1})"


def _part_lines(parts: list[Facts]) -> list[Line]:
    """Return one line for each part and one for each type of channel in it."""
    lines = []
    for count, part in enumerate(parts, start=1):
        name = f" {part['name']!r}" if part["name"] else ""
        lines.append((f"part {count}", f"{part['type']}, {part['compression']}{name}"))
        by_type: dict[str, list[str]] = {}
        for channel, pixel_type in part["channels"].items():
            by_type.setdefault(pixel_type, []).append(channel)
        lines += [(f"  {pixel_type}", ", ".join(names)) for pixel_type, names in by_type.items()]
    return lines


def _camera_lines(camera: Facts) -> list[Line]:
    """Return the lens values of the header, each with the attribute it comes from."""
    lines = []
    for label, name, unit in _CAMERA_LINES:
        if camera[name] is not None:
            value = f"{_number_text(camera[name])} {unit}".rstrip()
            lines.append((label, f"{value} ({_value_source_text(camera['sources'][name])})"))
        elif name in camera["refused"]:
            reason = "ignored: no real lens has this value"
            lines.append((label, f"none (header: {camera['refused'][name]}: {reason})"))
    if camera["model"] is None:
        lines = lines or [("camera", "nothing in the header")]
        lines.append(("lens model", f"{LensModel.PHOTOGRAPHIC} (the header names no CG renderer)"))
    return lines


def _value_source_text(source: str) -> str:
    return source if source.startswith("header, ") else f"header: {source}"


def _primaries_lines(primaries: Facts | None) -> list[Line]:
    """Return the primaries of the colors, and the attribute that states them."""
    if primaries is None:
        return [("primaries", "linear Rec.709 (the header names no other)")]
    if primaries["space"] is None:
        conversion = "unknown to heatlens; taken as the current input space"
        if primaries["by_matrix"]:
            conversion = "converted to linear Rec.709 by a matrix for display"
        return [
            ("primaries", f"{primaries['value']} (header: {primaries['attribute']}), {conversion}")
        ]
    return [("primaries", f"{primaries['space']} (header: {primaries['attribute']})")]


def _color_lines(color: Facts) -> list[Line]:
    """Return layer and range of the color, or why there is none."""
    lines = []
    if "layer" in color:
        alpha = "with alpha" if color["has_alpha"] else "no alpha"
        view = f" of the view {color['view']}" if color["view"] else ""
        lines.append(("colour", f"{color['layer'] or 'RGB'}{view}, {alpha}"))
        range_text = "no finite value"
        if color["min"] is not None:
            range_text = f"{_number_text(color['min'])} to {_number_text(color['max'])}"
        invalid_counts = f"{color['nan_count']} NaN, {color['infinite_count']} infinite"
        lines.append(("colour range", f"{range_text}, {invalid_counts}"))
    if "problem" in color:
        lines.append(("colour", f"none: {color['problem']}"))
    return lines


def _depth_lines(depth: Facts) -> list[Line]:
    """Return channel, convention with its reason and range of the depth, or why there is none."""
    if "problem" in depth:
        return [("depth", f"none: {depth['problem']}")]
    lines = [
        ("depth", f"{depth['channel']}, {depth['convention']}, {depth['kind']}"),
        ("  why", depth["why"]),
    ]
    if "min_px" in depth:
        range_text = (
            f"{_number_text(depth['min_px'])} to {_number_text(depth['max_px'])} px, signed "
            "diameter"
        )
        return [*lines, ("  range", range_text)]
    range_text = f"{_number_text(depth['near_m'])} to {_number_text(depth['far_m'])} m"
    if depth["near_m"] == "infinity":
        range_text = "none: every pixel is infinitely far"
    counts = f"{depth['infinite_count']} px infinite, {depth['repaired_count']} px repaired"
    return [*lines, ("  range", range_text), ("  counts", counts)]


def _behind_lines(behind: list[Facts]) -> list[Line]:
    """Return what each picture behind adds, or why it cannot be added."""
    return [
        (
            "behind",
            f"{picture['name']} {picture['words']}"
            + (f": {picture['problem']}" * bool(picture["problem"])),
        )
        for picture in behind
    ]


def _number_text(value: float | str) -> str:
    """Format a number with five digits; infinity is already a word."""
    return value if isinstance(value, str) else f"{value:.5g}"
