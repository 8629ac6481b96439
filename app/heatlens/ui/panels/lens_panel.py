"""Draw the Lens panel: focus, aperture, hardware, and how the blur is computed."""

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

from imgui_bundle import imgui

from heatlens.base.errors import LensError
from heatlens.model.coc import depth_of_field_m, far_limit_m, hyperfocal_m, near_limit_m
from heatlens.model.depth_histogram import DepthHistogram
from heatlens.model.f_stops import THIRD_STOPS, nearest_index
from heatlens.model.filmback import FILMBACKS
from heatlens.model.lens import Lens
from heatlens.model.lens_kit import KitLens
from heatlens.model.lens_model import LensModel
from heatlens.model.measured_distance import measured_text, parse_measured_m
from heatlens.model.measured_from import MeasuredFrom
from heatlens.model.option import options_of
from heatlens.model.plausibility import About, Doubt
from heatlens.model.settings import (
    PARTS,
    Bokeh,
    DefocusSettings,
    Method,
    Quality,
    barred_methods,
)
from heatlens.model.shot import LensParameter
from heatlens.model.units import format_distance
from heatlens.session.lens.lens_commands import nudged
from heatlens.session.loop.messages import Problem, window_words
from heatlens.ui import probe, theme, widgets

_CUSTOM = "custom"
_LIMITS_EM = 20.0  # below this width, four equal columns would cut their text
_NO_T_STOP = "as the f-stop"
_VIEWS_REACH = 4096  # largest value of the slider
_PROXIES = {"full": 1.0, "1/2": 0.5, "1/3": 1 / 3, "1/4": 0.25}
_SET_UP_ONCE = (
    *("film back", "sensor width", "lens model", "distances from", "pupil offset", "squeeze"),
    "sharp up to",
)
_LENS_IS_FIXED = "This plate holds circles of confusion, so its lens is fixed."
_KNOB = imgui.Col_.slider_grab
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


def lens_panel(lens: Lens, facts: LensFacts, say: Say) -> Lens:
    """Draw the controls of the lens; return the lens as the user left it."""
    before = lens
    try:
        lens = _focus(lens, facts, say)
        with _tried(LensParameter.F_STOP, facts), widgets.colored(theme.colors.live, _KNOB):
            lens = _aperture(lens, facts, say)
        with _tried(LensParameter.FOCAL_LENGTH, facts):
            lens = _hardware(lens, facts, say)
        _doubts(facts, "lens")
    except LensError as error:  # the change gives an impossible lens, so it is discarded
        say(Problem(error))
        return before
    _sources(facts)
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
    notches = widgets.wheel_over_last()
    if distance_m != lens.focus_distance_m:
        lens = replace(lens, focus_distance_m=distance_m)
    if notches:
        lens = nudged(lens, facts.histogram, notches)
    _doubts(facts, "focus")
    _doubts(facts, "depth")
    _limits(lens, facts.unit)
    return lens


def _tried(parameter: LensParameter, facts: LensFacts) -> AbstractContextManager[None]:
    """Draw the block in another colour if the value holds at this frame only, without a key."""
    return widgets.colored(theme.colors.tried if parameter in facts.tried else None)


def _doubts(facts: LensFacts, about: About) -> None:
    """Draw the doubts about a field under it, with their remedy."""
    for doubt in facts.doubts:
        if doubt.about == about:
            widgets.colored_text(window_words(doubt.sentence), theme.colors.bad)
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
    if imgui.is_item_hovered():
        imgui.set_tooltip(f"What blurs to less than {limit_um:.0f} µm on the sensor is sharp.")


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
    f_stop = widgets.text_field(
        "f-stop field",
        f"f/{lens.f_stop:.4g}",
        lens.f_stop,
        lambda text: widgets.parse_number(text, 0.1, 128.0, "f-stop"),
        say,
    )
    if f_stop != lens.f_stop:
        lens = replace(lens, f_stop=f_stop)
    _doubts(facts, "aperture")
    return _t_stop(lens, say)


def _t_stop(lens: Lens, say: Say) -> Lens:
    tip = "Transmission of the glass: it changes the exposure, never the blur. Empty: no loss."
    widgets.label("T-stop", tip)
    shown = "" if lens.t_stop is None else f"T{lens.t_stop:.4g}"
    t_stop = widgets.text_field("T-stop", shown, lens.t_stop, _parse_t_stop, say, _NO_T_STOP)
    return lens if t_stop == lens.t_stop else replace(lens, t_stop=t_stop)


def _parse_t_stop(text: str) -> float | None:
    return widgets.parse_number(text, 0.1, 128.0, "T-stop") if text.strip() else None


def _sources(facts: LensFacts) -> None:
    """Draw where the first values of the lens came from: the plate's file, or assumed."""
    options = options_of(Lens)
    words = [f"{options[name].words}: {why}" for name, why in facts.sources.items()]
    if not words:
        return
    assumed = any("assumed" in why or "nothing" in why for why in facts.sources.values())
    imgui.text_disabled("began with assumed values" if assumed else "began with the plate's lens")
    if imgui.is_item_hovered():
        imgui.set_tooltip("\n".join(words))


def _hardware(lens: Lens, facts: LensFacts, say: Say) -> Lens:
    imgui.separator_text("Lens")
    ends = 4.0, 1200.0
    if facts.kit_lens is not None:
        ends = facts.kit_lens.focal_length_mm, facts.kit_lens.longest
    with widgets.disabled(ends[0] == ends[1]):  # a prime lens has one focal length
        focal = widgets.drag("focal length", lens.focal_length_mm, 0.2, *ends, "%.1f mm", say)
    if focal != lens.focal_length_mm:
        lens = replace(lens, focal_length_mm=focal)
    return lens


def film_back_panel(lens: Lens, say: Say) -> Lens:
    """Draw what is set up once a shoot, folded until it is opened or sought."""
    if not widgets.folded("Film back, squeeze, sharpness", _SET_UP_ONCE):
        return lens
    try:
        return _film_back(lens, say)
    except LensError as error:  # the change gives an impossible lens, so it is discarded
        say(Problem(error))
        return lens


def _film_back(lens: Lens, say: Say) -> Lens:
    lens = _measured(_model(_sensor(lens, say)), say)
    squeeze = widgets.slider(
        "squeeze",
        lens.squeeze,
        1.0,
        2.0,
        "%.2f x",
        "Anamorphic: how many times as tall as wide discs are.",
    )
    if squeeze != lens.squeeze:
        lens = replace(lens, squeeze=squeeze)
    limit_um = widgets.drag(
        "sharp up to",
        1e3 * lens.coc_limit_mm,
        0.2,
        1.0,
        500.0,
        "%.1f µm",
        say,
        "Acceptable circle of confusion on the sensor; 1/1500 of its width unless set.",
    )
    if not math.isclose(limit_um, 1e3 * lens.coc_limit_mm, rel_tol=1e-6):
        lens = replace(lens, acceptable_coc_mm=1e-3 * limit_um)
    return lens


def _model(lens: Lens) -> Lens:
    """Draw the choice of the lens model, which decides the size of the discs."""
    by_words = {model.facts.words: model for model in LensModel}
    tip = "\n".join(f"{words}: {model.facts.meaning}" for words, model in by_words.items())
    picked = by_words[widgets.choice("lens model", lens.model.facts.words, list(by_words), tip)]
    return lens if picked is lens.model else replace(lens, model=picked)


def _measured(lens: Lens, say: Say) -> Lens:
    """Draw where distances are measured from, and the offset of the pupil from the film plane."""
    names = [start.words for start in MeasuredFrom]
    tip = "The depth of a plate starts at the entrance pupil, a tape measure at the film plane."
    picked = widgets.choice("distances from", lens.measured_from.words, names, tip)
    start = next(start for start in MeasuredFrom if start.words == picked)
    if start is not lens.measured_from:
        lens = replace(lens, measured_from=start)
    if start is MeasuredFrom.FILM:
        tip = "From the film plane to the entrance pupil; some cameras record it."
        widgets.label("pupil offset", tip)
        text = widgets.text_field(
            "pupil offset", f"{lens.pupil_offset_mm:.4g} mm", lens.pupil_offset_mm, _parse_mm, say
        )
        lens = lens if text == lens.pupil_offset_mm else replace(lens, pupil_offset_mm=text)
    return lens


def _parse_mm(text: str) -> float:
    return widgets.parse_number(text, -2000.0, 2000.0, "pupil offset")


def _sensor(lens: Lens, say: Say) -> Lens:
    known = next((b.name for b in FILMBACKS if b.width_mm == lens.sensor_width_mm), _CUSTOM)
    names = [back.name for back in FILMBACKS]
    picked = widgets.choice("film back", known, names)
    if picked != known:
        width_mm = next(back.width_mm for back in FILMBACKS if back.name == picked)
        lens = replace(lens, sensor_width_mm=width_mm)
    width_mm = widgets.drag("sensor width", lens.sensor_width_mm, 0.05, 1.0, 100.0, "%.2f mm", say)
    return lens if width_mm == lens.sensor_width_mm else replace(lens, sensor_width_mm=width_mm)


def blur_panel(settings: DefocusSettings, has_many_views: bool) -> DefocusSettings:
    """Draw the settings of the blur; return them as the user left them."""
    imgui.separator_text("Blur")
    tip = (
        "diffusion is heatlens's own; the others are for comparison, and use no bokeh or layers. "
        "accumulation and raytraced render a 3D scene through the whole lens."
    )
    methods, barred = [str(m) for m in Method], barred_methods(has_many_views)
    method = widgets.choice("method", str(settings.method), methods, tip, barred)
    if settings.method.needs_scene:
        settings = _views(settings)
    bokeh = widgets.choice("bokeh", str(settings.bokeh), [str(b) for b in Bokeh])
    quality = widgets.choice(
        "quality",
        str(settings.quality),
        [str(q) for q in Quality],
        "How finely the blur is computed, never how much there is.",
    )
    auto = "as quality says"
    layers_shown = auto if settings.layers is None else str(settings.layers)
    counts = [auto, *map(str, _whole_numbers("layers"))]
    layers = widgets.choice("layers", layers_shown, counts)
    tip = "Of the lens: surfaces behind the focus overlap rightly where those behind are known."
    parts = widgets.choice("parts", str(settings.parts), [str(n) for n in PARTS], tip)
    proxy_shown = next((n for n, v in _PROXIES.items() if v == settings.proxy), _CUSTOM)
    proxy = widgets.choice("picture size", proxy_shown, list(_PROXIES))
    return replace(
        settings,
        method=Method(method),
        bokeh=Bokeh(bokeh),
        quality=Quality(quality),
        layers=None if layers == auto else int(layers),
        parts=int(parts),
        proxy=_PROXIES.get(proxy, settings.proxy),
    )


def _views(settings: DefocusSettings) -> DefocusSettings:
    """Draw the number of views through the lens, which may exceed the range of the slider."""
    tip = "Points of the lens to look through, or rays for each pixel. More give less noise."
    widgets.label("views", tip)
    width = imgui.get_content_region_avail().x - widgets.VALUE_EM * imgui.get_font_size()
    imgui.set_next_item_width(width)
    flags = imgui.SliderFlags_.logarithmic
    changed, views = imgui.slider_int("##views", settings.views, 1, _VIEWS_REACH, "", flags)
    probe.note("views")
    imgui.same_line()
    imgui.text(str(settings.views))
    allowed = _whole_numbers("views")
    views = min(max(views, allowed[0]), allowed[-1])
    return replace(settings, views=views) if changed else settings


def _whole_numbers(name: str) -> range:
    """Return the allowed values of a field of the settings."""
    limits = options_of(DefocusSettings)[name]
    assert limits.least is not None and limits.most is not None
    return range(int(limits.least), int(limits.most) + 1)
