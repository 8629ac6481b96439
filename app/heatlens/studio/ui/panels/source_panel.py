"""Draw what the Source panel shows of a plate: how its depth was read and why, and other ways."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import window_words
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.focus.plausibility import Doubt
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.units import (
    FOOT_M,
    INCH_M,
    format_distance,
    label_distance,
    parse_distance_m,
)
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.media.plate.header.channel_choice import color_layers_among, depth_channels_first
from heatlens.media.plate.header.entries import FOR_THE_EYE
from heatlens.media.plate.plate import CameraHeader, Plate
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.panels.depth_scale import draw_histogram, draw_scale
from heatlens.studio.ui.panels.source_rows import behind_rows

_BAR_EM = 4.2
_BY_NAME = "found by name"
_CONVENTIONS = {convention: convention.facts.label for convention in DepthConvention}
_KINDS = {kind: kind.label for kind in DepthKind}
_NEIGHBOURS = {None: "automatic", 0: "none"} | {it: f"{it} on either side" for it in (1, 2, 4, 8)}
_NEIGHBOURS_TIP = (
    "Other frames of the sequence, used to see what is hidden here. Automatic: 2 on either side if "
    "the headers have the camera."
)
_UNITS = {1.0: "m", 1e-2: "cm", 1e-3: "mm", 1e3: "km", FOOT_M: "ft", INCH_M: "in"}
Notify = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class PlateFacts:
    """The values that the panel shows besides the options."""

    plate: Plate
    histogram: DepthHistogram | None  # None if the plate has no distances
    hovered_m: float | None  # distance under the pointer
    unit: str  # m or ft
    problem: str  # why the plate cannot be read with the chosen options, or ""
    lens: Lens  # gives radial depth the focal length and sensor that the header lacks
    doubts: tuple[Doubt, ...] = ()  # implausible values of lens and depths
    read_options: PlateOptions = field(
        default_factory=PlateOptions
    )  # options the plate was read with


def plate_panel(
    options: PlateOptions, facts: PlateFacts, notify: Notify, ask_behind: Callable[[], None]
) -> PlateOptions:
    """Draw the panel; return the options for reading the plate, as the user left them.

    `ask_behind` opens the dialog for another background picture.
    """
    is_behind_problem = replace(options, behind=facts.read_options.behind) == facts.read_options
    depth_rows(facts)
    imgui.separator_text("Read as")
    options = _reading_rows(options, facts, notify)
    if not is_behind_problem:
        texts.colored_text(facts.problem, theme.colors.bad)
    if widgets.button("Guess again", "Guess again", width=-1):
        options = PlateOptions(
            depth_source=options.depth_source,
            depth_model=options.depth_model,
            behind=options.behind,
        )
    reports = {report.name: report for report in facts.plate.behind}
    behind = behind_rows(
        options.behind, reports, facts.problem if is_behind_problem else "", ask_behind
    )
    neighbours = widgets.pick("neighbours", options.neighbours, _NEIGHBOURS, _NEIGHBOURS_TIP)
    file_rows(facts)
    return replace(options, behind=behind, neighbours=neighbours)


# What was read


def depth_rows(facts: PlateFacts) -> None:
    """Draw the histogram, the range of distances, and how and why the depth was read."""
    imgui.separator_text("Depth")
    report, rows = facts.plate.depth, []
    if facts.histogram is not None:
        _draw_histogram_bar(facts.histogram, facts)
        hovered_text = (
            "-" if facts.hovered_m is None else _distance_words(facts.hovered_m, facts.unit)
        )
        range_text = (
            f"{_distance_words(report.near_m, facts.unit)} to "
            f"{_distance_words(report.far_m, facts.unit)}"
        )
        rows += [("pointer", hovered_text), ("surfaces", range_text)]
    if report.infinite_count:
        rows.append(("nothing hit", _pixel_share_words(report.infinite_count, facts.plate)))
    if report.repaired_count:
        rows.append(("repaired", _pixel_share_words(report.repaired_count, facts.plate)))
    reading_text = f"{report.channel}: {report.convention.facts.label}, {report.kind.label}"
    rows.append(("taken for", reading_text))
    rows.append(("because", window_words(report.why)))
    for name, text in rows:
        _fact_row(name, text)


def _draw_histogram_bar(histogram: DepthHistogram, facts: PlateFacts) -> None:
    """Draw the histogram of distances, with the distance under the pointer."""
    em = imgui.get_font_size()
    corner = imgui.get_cursor_screen_pos()
    size = ImVec2(imgui.get_content_region_avail().x, _BAR_EM * em)
    imgui.dummy(size)
    rects.note("plate histogram")
    draw, text_y = imgui.get_window_draw_list(), corner.y + size.y - em
    draw.add_rect_filled(corner, ImVec2(corner.x + size.x, text_y - 2), theme.colors.groove, 3.0)
    draw_histogram(draw, histogram, corner, ImVec2(size.x, text_y - 2 - corner.y))
    draw_scale(draw, histogram, corner, ImVec2(size.x, text_y - corner.y), facts.unit)
    if facts.hovered_m is not None:
        x = corner.x + (1.0 - histogram.scale_position(facts.hovered_m)) * size.x
        draw.add_line(ImVec2(x, corner.y - 2), ImVec2(x, text_y), theme.colors.handle, 2.0)


def file_rows(facts: PlateFacts) -> None:
    """Draw the file's name, size, header, channels and notes."""
    plate, unit = facts.plate, facts.unit
    imgui.separator_text("File")
    _fact_row("name", plate.path.name)
    _fact_row("folder", str(plate.path.absolute().parent))
    data_window, display_window = plate.data_window, plate.display_window
    ratio = plate.pixel_aspect_ratio
    pixels = "" if ratio == 1.0 else f", pixel aspect {ratio:g}"
    _fact_row("size", f"{display_window.width} x {display_window.height}{pixels}")
    if data_window != display_window:
        x, y = data_window.relative_to(display_window).corner
        _fact_row("data window", f"{data_window.width} x {data_window.height} at {x}, {y}")
    _fact_row("alpha", "yes" if plate.has_alpha else "none")
    _fact_row("header", _camera_words(plate.camera, unit))
    _fact_row("channels", ", ".join(plate.aovs))
    behind_sentences = {report.sentence for report in plate.behind}
    for note in plate.notes:
        if note not in behind_sentences:
            _fact_row("note", note)


def _camera_words(camera: CameraHeader, unit: str) -> str:
    """Return the lens data of the header, if there are any."""
    height_mm = camera.sensor_height_mm
    height = "" if height_mm is None else f" x {height_mm:g}"
    numbers = (
        ("focal length", camera.focal_length_mm, "{:g} mm"),
        ("sensor", camera.sensor_width_mm, f"{{:g}}{height} mm"),
        ("f-stop", camera.f_stop, "f/{:g}"),
        ("T-stop", camera.t_stop, "T{:g}"),
    )
    values = [f"{name} {text.format(value)}" for name, value, text in numbers if value is not None]
    if camera.focus_distance_m is not None:
        values.append(f"focus {format_distance(camera.focus_distance_m, unit)}")
    return ", ".join(values) or "tells no lens"


def _fact_row(name: str, text: str) -> None:
    widgets.fact_row(name, text, f"plate {name}")


def _distance_words(distance_m: float, unit: str) -> str:
    return "no surface" if math.isinf(distance_m) else label_distance(distance_m, unit)


def _pixel_share_words(count: int, plate: Plate) -> str:
    """Return a count of pixels, and the percentage of the data window."""
    share = count / (plate.data_window.width * plate.data_window.height)
    return f"{count} pixels, {100 * share:.3g} %"


# How to read it


def _reading_rows(options: PlateOptions, facts: PlateFacts, notify: Notify) -> PlateOptions:
    """Draw the controls of depth, color and eye; return the options as the user left them."""
    plate = facts.plate
    names = depth_channels_first(plate.aovs)
    channel = _name_choice(
        "channel", options.depth_channel, names, "The channel that holds the depth."
    )
    tip = f"What its values mean. Now: {options.depth_convention.facts.meaning}."
    convention = widgets.pick("convention", options.depth_convention, _CONVENTIONS, tip)
    if plate.depth.question:
        texts.colored_text(window_words(plate.depth.question), theme.colors.message)
        rects.note("question about the convention")
    options = replace(options, depth_channel=channel, depth_convention=convention)
    options = _end_rows(options, facts.unit, notify)
    options = _kind_row(options, facts)
    options = _unit_rows(options, notify)
    for doubt in facts.doubts:
        if doubt.about != "lens":
            texts.colored_text(window_words(doubt.sentence), theme.colors.bad)
            rects.note("doubt about the unit")
    layers = color_layers_among(plate.aovs)
    options = replace(
        options, color_layer=_name_choice("colour layer", options.color_layer, layers)
    )
    tip = "Removes single pixels far brighter than their neighbours, a fault of path tracers."
    despike = widgets.check("remove fireflies", options.despike, tip=tip)
    options = replace(options, despike=despike)
    if plate.attributes.get(FOR_THE_EYE):
        options = _highlights_row(options)
    if not plate.views:
        return options
    return replace(
        options, eye=_name_choice("eye", options.eye, plate.views, "The view of a stereo file.")
    )


def _highlights_row(options: PlateOptions) -> PlateOptions:
    """Draw the choice of how many stops brighter clipped light becomes."""
    higher_stops = {float(stops): f"{stops} stops brighter" for stops in range(2, 7)}
    words = {0.0: "stay at white", 1.0: "1 stop brighter"} | higher_stops
    stops = options.lift_highlights_stops
    words.setdefault(stops, f"{stops:g} stops brighter")
    tip = "Light that the picture clips at white; lifted, its lamps glow out of focus."
    return replace(options, lift_highlights_stops=widgets.pick("highlights", stops, words, tip))


def _end_rows(options: PlateOptions, unit: str, notify: Notify) -> PlateOptions:
    """Draw the distances that depth 0 and 1 stand for, if the convention needs them."""
    with widgets.disabled(not options.depth_convention.facts.takes_ends):
        near = _distance_field("near", options.near_m, unit, notify)
        far = _distance_field("far", options.far_m, unit, notify)
    return replace(options, near_m=near, far_m=far)


def _distance_field(name: str, value: float | None, unit: str, notify: Notify) -> float | None:
    """Draw the field of an optional distance; return the changed value in m, None for unknown."""
    tip = "The distance at this end of the range 0 to 1: 0.5, 30cm, 6'3\"; empty: unknown."
    widgets.label(name, tip)
    value_text = "" if value is None else format_distance(value, unit)
    parse = widgets.optional(_parse_end_m)
    return widgets.text_field(name, value_text, value, parse, notify, "unknown")


def _parse_end_m(text: str) -> float:
    """Parse a finite distance in m. Raise InputError for infinity."""
    distance_m = parse_distance_m(text)
    if distance_m == math.inf:
        raise InputError("The ends of a depth must be finite distances.")
    return distance_m


def _kind_row(options: PlateOptions, facts: PlateFacts) -> PlateOptions:
    """Draw the choice of the kind of depth.

    Radial depth needs a camera: values that the header lacks are taken from the lens of the shot.
    """
    tip = (
        "Along the axis, a wall seen head-on has one depth; along the ray, its corners are farther."
    )
    kind = widgets.pick("kind", options.depth_kind, _KINDS, tip)
    if kind == options.depth_kind:
        return options
    camera, lens = facts.plate.camera, facts.lens
    if kind is DepthKind.RADIAL and (
        camera.focal_length_mm is None or camera.sensor_width_mm is None
    ):
        return replace(
            options,
            depth_kind=kind,
            focal_length_mm=camera.focal_length_mm or lens.focal_length_mm,
            sensor_width_mm=camera.sensor_width_mm or lens.sensor_width_mm,
        )
    return replace(options, depth_kind=kind)


def _unit_rows(options: PlateOptions, notify: Notify) -> PlateOptions:
    """Draw the choice of the scene unit, by name or in meters."""
    with widgets.disabled(not options.depth_convention.facts.has_unit):
        old_m = options.scene_unit_m
        known_m = next((unit_m for unit_m in _UNITS if math.isclose(unit_m, old_m)), old_m)
        picked_m = widgets.pick("scene unit", known_m, _UNITS)
        unit_m = old_m if picked_m == known_m else picked_m
        widgets.label("in metres", "Metres in one unit of the depth.")
        parse = partial(widgets.parse_number, low=1e-6, high=1e6, quantity="scene unit")
        unit_m = widgets.text_field("in metres", f"{unit_m:.6g}", unit_m, parse, notify)
    return replace(options, scene_unit_m=unit_m)


def _name_choice(name: str, value: str | None, names: Sequence[str], tip: str = "") -> str | None:
    """Draw the choice of a channel or layer of the file by its name; None finds it by itself."""
    choices = {_BY_NAME: None} | {text or "(no name)": text for text in names}
    current_text = next((text for text, key in choices.items() if key == value), value or _BY_NAME)
    picked_text = widgets.choice(name, current_text, list(choices), tip)
    return choices.get(picked_text, value)
