"""Draw the Lens panel: focus, aperture and hardware."""

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial

from imgui_bundle import imgui

from heatlens.core.base.messages import report_errors, window_words
from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.coc import depth_of_field_m, far_limit_m, hyperfocal_m, near_limit_m
from heatlens.core.model.focus.plausibility import About, Doubt
from heatlens.core.model.lens.filmback import FILMBACKS, Filmback
from heatlens.core.model.lens.lens import (
    THIRD_STOPS,
    Lens,
    LensModel,
    MeasuredFrom,
    as_measured_m,
    measured_text,
    nearest_index,
    parse_measured_m,
)
from heatlens.core.model.lens.lens_kit import KitLens, LensKit
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.units import format_distance, label_distance
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.media.plate.coc_line import nudge_lens
from heatlens.studio.board.controls import LensControl
from heatlens.studio.ui import rects, texts, theme, widgets

_LIMITS_EM = 20.0  # below this width, four equal columns would cut their text
_NO_T_STOP = "same as f-stop"
_FOLDED_ROWS = (
    *("film back", "sensor width", "lens model", "distances from", "pupil offset", "squeeze"),
    "sharp up to",
)
_LENS_IS_FIXED = "This plate holds circles of confusion, so its lens is fixed."
_KNOB = imgui.Col_.slider_grab
_BREATHING_TIP = "At close focus the lens shows {:.3g} % of the width that it shows at infinity."
_NO_KIT = "no kit"
Notify = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class LensFacts:
    """The values that the panel shows besides the lens."""

    histogram: DepthHistogram | None  # None if the plate has no distances or nothing is open
    unit: str  # m or ft
    sources: Mapping[str, str]  # field of the lens -> where its first value came from
    # Parameters changed at this frame without a key.
    trial_parameters: frozenset[LensParameter] = frozenset()
    doubts: tuple[Doubt, ...] = ()  # implausible values of the lens, given the depths
    brings_coc: bool = False  # the plate has circles of confusion instead of distances
    kit_lens: KitLens | None = None  # the lens of a kit, which limits the values; None: no limits


# Film back, model and sharpness are folded at first, so that the kit and the opening are visible in
# a window of 1280 x 800.
def lens_panel(
    lens: Lens,
    facts: LensFacts,
    notify: Notify,
    draw_mark_buttons: Callable[[], None] = lambda: None,
) -> Lens:
    """Draw the controls of the lens; return the lens as the user left it.

    `draw_mark_buttons` draws the buttons under the focus, which set a mark and pull to one.
    """
    with report_errors(notify):  # a change that gives an impossible lens is discarded
        new_lens = _focus_rows(lens, facts, notify)
        if facts.histogram is not None:
            draw_mark_buttons()
        with _trial_color(LensParameter.F_STOP, facts), texts.colored(theme.colors.live, _KNOB):
            new_lens = _aperture_rows(new_lens, facts, notify)
        with _trial_color(LensParameter.FOCAL_LENGTH, facts):
            new_lens = _focal_length_row(new_lens, facts, notify)
        _draw_doubts(facts, "lens")
        _draw_sources(facts)
        return new_lens
    return lens


def _focus_rows(lens: Lens, facts: LensFacts, notify: Notify) -> Lens:
    """Draw the field of the focus distance and the limits of the sharp range."""
    imgui.separator_text("Focus")
    if facts.histogram is None:
        if facts.brings_coc:
            imgui.text_wrapped(_LENS_IS_FIXED)
        return lens
    tip = f"2.24, 190cm, 6'3\" or inf, from the {lens.measured_from.words}"
    widgets.label("distance", tip)
    with _trial_color(LensParameter.FOCUS_DISTANCE, facts):
        distance_m = widgets.text_field(
            "distance",
            measured_text(lens, lens.focus_distance_m, facts.unit),
            lens.focus_distance_m,
            lambda text: parse_measured_m(lens, text),
            notify,
        )
    lens, notches = replace(lens, focus_distance_m=distance_m), widgets.wheel_over_last()
    if notches:
        lens = nudge_lens(lens, facts.histogram, notches)
    _draw_doubts(facts, "focus")
    _draw_doubts(facts, "depth")
    _draw_limits(lens, facts.unit)
    return lens


def _trial_color(parameter: LensParameter, facts: LensFacts) -> AbstractContextManager[None]:
    """Draw the block in another color if the parameter has a trial value at this frame."""
    return texts.colored(theme.colors.trial if parameter in facts.trial_parameters else None)


def _draw_doubts(facts: LensFacts, about: About) -> None:
    """Draw the doubts about a field under it, with their remedy."""
    for doubt in facts.doubts:
        if doubt.about == about:
            texts.colored_text(window_words(doubt.sentence), theme.colors.bad)
            rects.note(f"doubt about {about}")


def _draw_limits(lens: Lens, unit: str) -> None:
    """Draw the near and far limit, the depth of field and the hyperfocal distance."""
    is_narrow = imgui.get_content_region_avail().x < _LIMITS_EM * imgui.get_font_size()
    flags = imgui.TableFlags_
    limits_m = {
        "near": as_measured_m(lens, near_limit_m(lens)),
        "far": as_measured_m(lens, far_limit_m(lens)),
        "in focus": depth_of_field_m(lens),
        "hyperfocal": as_measured_m(lens, hyperfocal_m(lens)),
    }
    if imgui.begin_table("limits", 4, flags.sizing_stretch_prop if is_narrow else flags.none):
        for title, limit_m in limits_m.items():
            imgui.table_next_column()
            imgui.text_disabled(title)
            rects.note(title)
            imgui.text(label_distance(limit_m, unit))
            texts.tooltip(f"{title} {format_distance(limit_m, unit)}")
        imgui.end_table()
    limit_um = 1e3 * lens.coc_limit_mm
    texts.tooltip(f"A blur of less than {limit_um:.0f} µm on the sensor counts as sharp.")


def _aperture_rows(lens: Lens, facts: LensFacts, notify: Notify) -> Lens:
    """Draw the slider and the field of the f-stop, and the T-stop."""
    imgui.separator_text("Aperture")
    widgets.label("f-stop", "Third stops; type any value in the field on the right.")
    imgui.set_next_item_width(imgui.get_content_region_avail().x - 4.6 * imgui.get_font_size())
    index = nearest_index(lens.f_stop)
    widest_index = 0 if facts.kit_lens is None else nearest_index(facts.kit_lens.f_stop)
    has_changed, new_index = imgui.slider_int(
        "##f-stop", index, widest_index, len(THIRD_STOPS) - 1, ""
    )
    rects.note("f-stop")
    if has_changed and new_index != index:
        lens = replace(lens, f_stop=THIRD_STOPS[new_index])
    imgui.same_line()
    imgui.set_next_item_width(-1)
    f_stop_text = f"f/{lens.f_stop:.4g}"
    f_stop = widgets.text_field("f-stop field", f_stop_text, lens.f_stop, parse_stop, notify)
    lens = replace(lens, f_stop=f_stop)
    _draw_doubts(facts, "aperture")
    return _t_stop_row(lens, notify)


def _t_stop_row(lens: Lens, notify: Notify) -> Lens:
    """Draw the field of the T-stop; return the changed lens."""
    tip = "Transmission of the glass: it changes the exposure, never the blur. Empty: no loss."
    widgets.label("T-stop", tip)
    t_stop_text = "" if lens.t_stop is None else f"T{lens.t_stop:.4g}"
    parse = widgets.optional(partial(parse_stop, what="T-stop"))
    t_stop = widgets.text_field("T-stop", t_stop_text, lens.t_stop, parse, notify, _NO_T_STOP)
    return replace(lens, t_stop=t_stop)


def parse_stop(text: str, what: str = "f-stop") -> float:
    """Parse an f-stop or T-stop, with or without "f/". Raise InputError if no lens has it."""
    return widgets.parse_number(text, 0.1, 128.0, what)


def _draw_sources(facts: LensFacts) -> None:
    """Draw whether the first values of the lens came from the plate's file or are assumed."""
    options = options_of(Lens)
    words = [f"{options[name].words}: {source}" for name, source in facts.sources.items()]
    if not words:
        return
    assumed_names = [
        options[name].words
        for name, source in facts.sources.items()
        if "assumed" in source or "nothing" in source
    ]
    assumed_text = f"lens assumed: {', '.join(assumed_names)}"
    texts.gray_text(assumed_text if assumed_names else "lens from the file")
    texts.tooltip("\n".join(words))


def _focal_length_row(lens: Lens, facts: LensFacts, notify: Notify) -> Lens:
    """Draw the field of the focal length; return the changed lens."""
    imgui.separator_text("Lens")
    focal_range = 4.0, 1200.0
    if facts.kit_lens is not None:
        focal_range = facts.kit_lens.focal_length_mm, facts.kit_lens.longest_length_mm
    with widgets.disabled(focal_range[0] == focal_range[1]):  # a prime lens has one focal length
        focal_length_mm = widgets.drag(
            "focal length", lens.focal_length_mm, 0.2, *focal_range, "%.1f mm", notify
        )
    return replace(lens, focal_length_mm=focal_length_mm)


def film_back_panel(lens: Lens, notify: Notify) -> Lens:
    """Draw the rows that are set up once a shoot, folded until the user opens them."""
    if not widgets.folded_header("Film back, squeeze, sharpness", _FOLDED_ROWS):
        return lens
    with report_errors(notify):  # a change that gives an impossible lens is discarded
        return _film_back_rows(lens, notify)
    return lens


def _film_back_rows(lens: Lens, notify: Notify) -> Lens:
    """Draw sensor, lens model, measuring point, squeeze and the acceptable circle of confusion."""
    lens = _measuring_rows(_model_row(_sensor_rows(lens, notify)), notify)
    tip = "Anamorphic squeeze: the height of the discs divided by their width."
    lens = replace(lens, squeeze=widgets.slider("squeeze", lens.squeeze, 1.0, 2.0, "%.2f x", tip))
    tip = "Acceptable circle of confusion on the sensor; 1/1500 of its width unless set."
    limit_range = 1.0, 500.0
    old_limit_um = 1e3 * lens.coc_limit_mm
    limit_um = widgets.drag("sharp up to", old_limit_um, 0.2, *limit_range, "%.1f µm", notify, tip)
    if not math.isclose(limit_um, old_limit_um, rel_tol=1e-6):
        lens = replace(lens, acceptable_coc_mm=1e-3 * limit_um)
    return lens


def _model_row(lens: Lens) -> Lens:
    """Draw the choice of the lens model, which decides the size of the discs."""
    words = {model: model.facts.words for model in LensModel}
    tip = "\n".join(f"{text}: {model.facts.meaning}" for model, text in words.items())
    return replace(lens, model=widgets.pick("lens model", lens.model, words, tip))


def _measuring_rows(lens: Lens, notify: Notify) -> Lens:
    """Draw where distances are measured from, and the offset of the pupil from the film plane."""
    words = {start: start.words for start in MeasuredFrom}
    tip = "The depth of a plate starts at the entrance pupil, a tape measure at the film plane."
    start = widgets.pick("distances from", lens.measured_from, words, tip)
    lens = replace(lens, measured_from=start)
    if start is not MeasuredFrom.FILM:
        return lens
    name, old_offset_mm = "pupil offset", lens.pupil_offset_mm
    widgets.label(name, "From the film plane to the entrance pupil; some cameras record it.")
    parse = partial(widgets.parse_number, low=-2000.0, high=2000.0, quantity=name)
    offset_mm = widgets.text_field(name, f"{old_offset_mm:.4g} mm", old_offset_mm, parse, notify)
    return replace(lens, pupil_offset_mm=offset_mm)


def _sensor_rows(lens: Lens, notify: Notify) -> Lens:
    """Draw the choice of the film back and the width of the sensor."""
    names: dict[Filmback | None, str] = {back: back.name for back in FILMBACKS}
    old_width_mm = lens.sensor_width_mm
    current_back = next((back for back in FILMBACKS if back.width_mm == old_width_mm), None)
    picked_back = widgets.pick("film back", current_back, names)
    width_mm = old_width_mm if picked_back is None else picked_back.width_mm
    width_mm = widgets.drag("sensor width", width_mm, 0.05, 1.0, 100.0, "%.2f mm", notify)
    return replace(lens, sensor_width_mm=width_mm)


def kit_panel(kit: LensKit | None, lens: Lens, control: LensControl) -> None:
    """Draw the choice of the kit and of its lens, and the limits of that lens."""
    commands = control.commands.kits
    kit_name = None if kit is None else kit.name
    words: dict[str | None, str] = {None: _NO_KIT} | {name: name for name in commands.names}
    tip = "A set of lenses. It limits focal length, f-stop and focus."
    picked_name = widgets.pick("kit", kit_name, words, tip)
    if picked_name != kit_name:
        commands.choose(picked_name)
        return
    mounted_lens = commands.mounted_lens
    if kit is None or mounted_lens is None:
        return
    lenses = {kit_lens: kit_lens.name for kit_lens in kit.lenses}
    chosen_lens = widgets.pick("lens", mounted_lens, lenses, printable(kit.words))
    if chosen_lens != mounted_lens:
        commands.mount(chosen_lens)
    imgui.text_disabled(mounted_lens.words)
    if mounted_lens.breathing != 1.0:
        breathes, tip = lens.breathing != 1.0, _BREATHING_TIP.format(100 * mounted_lens.breathing)
        if widgets.check("the view breathes", breathes, "breathing", tip) != breathes:
            commands.breathe(not breathes)
