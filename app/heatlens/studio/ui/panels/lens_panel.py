"""Draw the Lens panel: focus, aperture and hardware."""

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial

from imgui_bundle import imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.coc import depth_of_field_m, far_limit_m, hyperfocal_m, near_limit_m
from heatlens.core.model.focus.plausibility import About, Doubt
from heatlens.core.model.lens.filmback import FILMBACKS, Filmback
from heatlens.core.model.lens.lens import (
    THIRD_STOPS,
    Lens,
    LensModel,
    MeasuredFrom,
    measured_text,
    nearest_index,
    parse_measured_m,
)
from heatlens.core.model.lens.lens_kit import KitLens, LensKit
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.units import format_distance
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.studio.session.lens.lens_commands import KitCommands, nudged
from heatlens.studio.session.messages import reported, window_words
from heatlens.studio.ui import probe, texts, theme, widgets

_LIMITS_EM = 20.0  # below this width, four equal columns would cut their text
_NO_T_STOP = "as the f-stop"
_SET_UP_ONCE = (
    *("film back", "sensor width", "lens model", "distances from", "pupil offset", "squeeze"),
    "sharp up to",
)
_LENS_IS_FIXED = "This plate holds circles of confusion, so its lens is fixed."
_KNOB = imgui.Col_.slider_grab
_BREATHING_TIP = "At close focus the lens shows {:.3g} % of the width that it shows at infinity."
_NO_KIT = "none: any lens"
Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class LensFacts:
    """What the panel shows besides the lens."""

    histogram: DepthHistogram | None  # None if the plate has no distances or nothing is open
    unit: str  # m or ft
    sources: Mapping[str, str]  # field of the lens -> where its first value came from
    tried: frozenset[LensParameter] = frozenset()  # parameters changed at this frame without a key
    doubts: tuple[Doubt, ...] = ()  # implausible values of the lens, given the depths
    brings_coc: bool = False  # the plate has circles of confusion instead of distances
    kit_lens: KitLens | None = None  # the lens of a kit, which limits the values; None: no limits


# Film back, model and sharpness are folded at first, so that the kit and the opening are seen in a
# window of 1280 x 800.
def lens_panel(lens: Lens, facts: LensFacts, say: Say) -> Lens:
    """Draw the controls of the lens; return the lens as the user left it."""
    with reported(say):  # a change that gives an impossible lens is discarded
        changed = _focus(lens, facts, say)
        with _tried(LensParameter.F_STOP, facts), texts.colored(theme.colors.live, _KNOB):
            changed = _aperture(changed, facts, say)
        with _tried(LensParameter.FOCAL_LENGTH, facts):
            changed = _hardware(changed, facts, say)
        _doubts(facts, "lens")
        _sources(facts)
        return changed
    return lens


def _focus(lens: Lens, facts: LensFacts, say: Say) -> Lens:
    imgui.separator_text("Focus")
    if facts.histogram is None:
        if facts.brings_coc:
            imgui.text_wrapped(_LENS_IS_FIXED)
        return lens
    tip = f"2.24, 190cm, 6'3\" or inf, from the {lens.measured_from.words}"
    widgets.label("distance", tip)
    with _tried(LensParameter.FOCUS_DISTANCE, facts):
        distance_m = widgets.text_field(
            "distance",
            measured_text(lens, lens.focus_distance_m, facts.unit),
            lens.focus_distance_m,
            lambda text: parse_measured_m(lens, text),
            say,
        )
    lens, notches = replace(lens, focus_distance_m=distance_m), widgets.wheel_over_last()
    if notches:
        lens = nudged(lens, facts.histogram, notches)
    _doubts(facts, "focus")
    _doubts(facts, "depth")
    _limits(lens, facts.unit)
    return lens


def _tried(parameter: LensParameter, facts: LensFacts) -> AbstractContextManager[None]:
    """Draw the block in another colour if the value holds at this frame only, without a key."""
    return texts.colored(theme.colors.tried if parameter in facts.tried else None)


def _doubts(facts: LensFacts, about: About) -> None:
    """Draw the doubts about a field under it, with their remedy."""
    for doubt in facts.doubts:
        if doubt.about == about:
            texts.colored_text(window_words(doubt.sentence), theme.colors.bad)
            probe.note(f"doubt about {about}")


def _limits(lens: Lens, unit: str) -> None:
    """Draw the near and far limit, the depth of field and the hyperfocal distance."""
    is_narrow = imgui.get_content_region_avail().x < _LIMITS_EM * imgui.get_font_size()
    flags = imgui.TableFlags_
    if imgui.begin_table("limits", 4, flags.sizing_stretch_prop if is_narrow else flags.none):
        for head, words in (
            ("near", measured_text(lens, near_limit_m(lens), unit)),
            ("far", measured_text(lens, far_limit_m(lens), unit)),
            ("in focus", format_distance(depth_of_field_m(lens), unit)),
            ("hyperfocal", measured_text(lens, hyperfocal_m(lens), unit)),
        ):
            imgui.table_next_column()
            imgui.text_disabled(head)
            probe.note(head)
            imgui.text(words)
        imgui.end_table()
    limit_um = 1e3 * lens.coc_limit_mm
    texts.tooltip(f"A blur of less than {limit_um:.0f} µm on the sensor counts as sharp.")


def _aperture(lens: Lens, facts: LensFacts, say: Say) -> Lens:
    imgui.separator_text("Aperture")
    widgets.label("f-stop", "Third stops; type any value in the field on the right.")
    imgui.set_next_item_width(imgui.get_content_region_avail().x - 4.6 * imgui.get_font_size())
    index = nearest_index(lens.f_stop)
    widest = 0 if facts.kit_lens is None else nearest_index(facts.kit_lens.f_stop)
    changed, new = imgui.slider_int("##f-stop", index, widest, len(THIRD_STOPS) - 1, "")
    probe.note("f-stop")
    if changed and new != index:
        lens = replace(lens, f_stop=THIRD_STOPS[new])
    imgui.same_line()
    imgui.set_next_item_width(-1)
    shown = f"f/{lens.f_stop:.4g}"
    f_stop = widgets.text_field("f-stop field", shown, lens.f_stop, parse_stop, say)
    lens = replace(lens, f_stop=f_stop)
    _doubts(facts, "aperture")
    return _t_stop(lens, say)


def _t_stop(lens: Lens, say: Say) -> Lens:
    tip = "Transmission of the glass: it changes the exposure, never the blur. Empty: no loss."
    widgets.label("T-stop", tip)
    shown = "" if lens.t_stop is None else f"T{lens.t_stop:.4g}"
    parse = widgets.optional(partial(parse_stop, what="T-stop"))
    t_stop = widgets.text_field("T-stop", shown, lens.t_stop, parse, say, _NO_T_STOP)
    return replace(lens, t_stop=t_stop)


def parse_stop(text: str, what: str = "f-stop") -> float:
    """Parse an f-stop or T-stop, with or without "f/". Raise InputError if no lens has it."""
    return widgets.parse_number(text, 0.1, 128.0, what)


def _sources(facts: LensFacts) -> None:
    """Draw where the first values of the lens came from: the plate's file, or assumed."""
    options = options_of(Lens)
    words = [f"{options[name].words}: {why}" for name, why in facts.sources.items()]
    if not words:
        return
    assumed = any("assumed" in why or "nothing" in why for why in facts.sources.values())
    imgui.text_disabled("began with assumed values" if assumed else "began with the plate's lens")
    texts.tooltip("\n".join(words))


def _hardware(lens: Lens, facts: LensFacts, say: Say) -> Lens:
    imgui.separator_text("Lens")
    ends = 4.0, 1200.0
    if facts.kit_lens is not None:
        ends = facts.kit_lens.focal_length_mm, facts.kit_lens.longest
    with widgets.disabled(ends[0] == ends[1]):  # a prime lens has one focal length
        focal = widgets.drag("focal length", lens.focal_length_mm, 0.2, *ends, "%.1f mm", say)
    return replace(lens, focal_length_mm=focal)


def film_back_panel(lens: Lens, say: Say) -> Lens:
    """Draw what is set up once a shoot, folded until it is opened or sought."""
    if not widgets.folded("Film back, squeeze, sharpness", _SET_UP_ONCE):
        return lens
    with reported(say):  # a change that gives an impossible lens is discarded
        return _film_back(lens, say)
    return lens


def _film_back(lens: Lens, say: Say) -> Lens:
    lens = _measured(_model(_sensor(lens, say)), say)
    tip = "Anamorphic squeeze: the height of the discs divided by their width."
    lens = replace(lens, squeeze=widgets.slider("squeeze", lens.squeeze, 1.0, 2.0, "%.2f x", tip))
    tip = "Acceptable circle of confusion on the sensor; 1/1500 of its width unless set."
    ends = 1.0, 500.0
    now_um = 1e3 * lens.coc_limit_mm
    limit_um = widgets.drag("sharp up to", now_um, 0.2, *ends, "%.1f µm", say, tip)
    if not math.isclose(limit_um, now_um, rel_tol=1e-6):
        lens = replace(lens, acceptable_coc_mm=1e-3 * limit_um)
    return lens


def _model(lens: Lens) -> Lens:
    """Draw the choice of the lens model, which decides the size of the discs."""
    words = {model: model.facts.words for model in LensModel}
    tip = "\n".join(f"{text}: {model.facts.meaning}" for model, text in words.items())
    return replace(lens, model=widgets.pick("lens model", lens.model, words, tip))


def _measured(lens: Lens, say: Say) -> Lens:
    """Draw where distances are measured from, and the offset of the pupil from the film plane."""
    words = {start: start.words for start in MeasuredFrom}
    tip = "The depth of a plate starts at the entrance pupil, a tape measure at the film plane."
    start = widgets.pick("distances from", lens.measured_from, words, tip)
    lens = replace(lens, measured_from=start)
    if start is not MeasuredFrom.FILM:
        return lens
    name, now_mm = "pupil offset", lens.pupil_offset_mm
    widgets.label(name, "From the film plane to the entrance pupil; some cameras record it.")
    parse = partial(widgets.parse_number, low=-2000.0, high=2000.0, what=name)
    offset_mm = widgets.text_field(name, f"{now_mm:.4g} mm", now_mm, parse, say)
    return replace(lens, pupil_offset_mm=offset_mm)


def _sensor(lens: Lens, say: Say) -> Lens:
    words: dict[Filmback | None, str] = {back: back.name for back in FILMBACKS}
    now_mm = lens.sensor_width_mm
    known = next((back for back in FILMBACKS if back.width_mm == now_mm), None)
    picked = widgets.pick("film back", known, words)
    width_mm = now_mm if picked is None else picked.width_mm
    width_mm = widgets.drag("sensor width", width_mm, 0.05, 1.0, 100.0, "%.2f mm", say)
    return replace(lens, sensor_width_mm=width_mm)


def kit_panel(kit: LensKit | None, lens: Lens, commands: KitCommands) -> None:
    """Draw the choice of the kit and of its lens, and the limits of that lens."""
    now = None if kit is None else kit.name
    words: dict[str | None, str] = {None: _NO_KIT} | {name: name for name in commands.names}
    tip = "A set of lenses. It limits focal length, f-stop and focus."
    picked = widgets.pick("kit", now, words, tip)
    if picked != now:
        commands.choose(picked)
        return
    mounted = commands.mounted
    if kit is None or mounted is None:
        return
    lenses = {kit_lens: kit_lens.name for kit_lens in kit.lenses}
    chosen = widgets.pick("lens", mounted, lenses, printable(kit.words))
    if chosen != mounted:
        commands.mount(chosen)
    imgui.text_disabled(mounted.words)
    if mounted.breathing != 1.0:
        breathes, tip = lens.breathing != 1.0, _BREATHING_TIP.format(100 * mounted.breathing)
        if widgets.check("the view breathes", breathes, "breathing", tip) != breathes:
            commands.breathe(not breathes)
