"""Draw how the blur is computed, as a part of the Lens panel."""

from dataclasses import replace

from imgui_bundle import imgui

from heatlens.core.model.option import options_of
from heatlens.core.model.shot.settings import PARTS, DefocusSettings, Quality, barred_methods
from heatlens.studio.ui import probe, widgets

_SLIDER_MAX_VIEWS = 4096  # largest value of the slider
_PROXIES = {1.0: "full", 0.5: "1/2", 1 / 3: "1/3", 0.25: "1/4"}


def blur_panel(settings: DefocusSettings, has_many_views: bool) -> DefocusSettings:
    """Draw the settings of the blur; return them as the user left them."""
    imgui.separator_text("Blur")
    tip = (
        "diffusion is heatlens's own; the others are for comparison, and ignore bokeh and layers. "
        "accumulation and raytraced render a 3D scene through the whole lens."
    )
    method = widgets.pick_one("method", settings.method, tip, barred_methods(has_many_views))
    if settings.method.needs_scene:
        settings = _views_row(settings)
    quality_tip = "How accurately the blur is computed; its size stays the same."
    qualities = {None: "film" + ", exports final" * (not has_many_views)} | {
        quality: str(quality) for quality in Quality
    }
    layers = {None: "as quality says"} | {
        number: str(number) for number in _whole_numbers("layers")
    }
    tip = "Parts of the lens. With more, known surfaces of different blur overlap correctly."
    return replace(
        settings,
        method=method,
        bokeh=widgets.pick_one("bokeh", settings.bokeh),
        quality=widgets.pick("quality", settings.quality, qualities, quality_tip),
        layers=widgets.pick("layers", settings.layers, layers),
        parts=widgets.pick("parts", settings.parts, {number: str(number) for number in PARTS}, tip),
        proxy=widgets.pick("picture size", settings.proxy, _PROXIES),
    )


def _views_row(settings: DefocusSettings) -> DefocusSettings:
    """Draw the number of views through the lens, which may exceed the range of the slider."""
    tip = "Points of the lens to look through, or rays for each pixel. More give less noise."
    widgets.label("views", tip)
    width = imgui.get_content_region_avail().x - widgets.VALUE_EM * imgui.get_font_size()
    imgui.set_next_item_width(width)
    flags = imgui.SliderFlags_.logarithmic
    has_changed, views = imgui.slider_int(
        "##views", settings.views, 1, _SLIDER_MAX_VIEWS, "", flags
    )
    probe.note("views")
    imgui.same_line()
    imgui.text(str(settings.views))
    allowed_views = _whole_numbers("views")
    views = min(max(views, allowed_views[0]), allowed_views[-1])
    return replace(settings, views=views) if has_changed else settings


def _whole_numbers(name: str) -> range:
    """Return the allowed values of a setting of the blur."""
    limits = options_of(DefocusSettings)[name]
    assert limits.least is not None and limits.most is not None
    return range(int(limits.least), int(limits.most) + 1)
