"""Draw how the blur is computed and how fast, as the last fold of the Lens panel.

It shows pictures per second, the time of each pass, memory and the GPU.
"""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from heatlens.core.base.memory import resident_bytes
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.settings import PARTS, DefocusSettings, Quality, barred_methods
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.preview.speed import Speed
from heatlens.studio.ui import rects, widgets
from heatlens.studio.ui.seek import is_highlighted

SPEED = "Speed"  # the heading, which a key and the palette look for
_ROWS = (
    *("method", "views", "rays a pixel", "bokeh", "quality", "layers", "parts", "picture size"),
    *("time each pass", SPEED),
)
_UNMEASURED = "\N{EN DASH}"

_SLIDER_MAX_VIEWS = 4096  # largest value of the slider
_PROXIES = {1.0: "full", 0.5: "1/2", 1 / 3: "1/3", 0.25: "1/4"}


def rendering_panel(
    settings: DefocusSettings, has_many_views: bool, draw_speed: Callable[[], None]
) -> DefocusSettings:
    """Draw the fold; return the settings of the blur as the user left them."""
    if not widgets.folded_header("Rendering", _ROWS):
        return settings
    settings = blur_rows(settings, has_many_views)
    draw_speed()
    return settings


def blur_rows(settings: DefocusSettings, has_many_views: bool) -> DefocusSettings:
    """Draw the settings of the blur; return them as the user left them."""
    tip = (
        "diffusion is heatlens's own; the others are for comparison, and ignore bokeh and layers. "
        "accumulation and raytraced render a 3D scene through the whole lens."
    )
    method = widgets.pick_one("method", settings.method, tip, barred_methods(has_many_views))
    if settings.method.needs_scene:
        settings = _views_row(settings)
    quality_tip = "How accurately the blur is computed; its size stays the same."
    qualities = {None: "film" + " (exports: final)" * (not has_many_views)} | {
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
    rects.note("views")
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


def speed_rows(
    speed: Speed, upload_s: float, picture: ShownPicture | None, renderer: FrameRenderer
) -> None:
    """Draw what pictures take; the checkbox switches the renderer's stopwatch."""
    is_highlighted(SPEED)  # scrolls to it
    imgui.separator_text(SPEED)
    imgui.text_disabled(renderer.ctx.name)
    rows = [
        ("window", _value_text(speed.mean_ms(), "{:.1f} ms a frame")),
        ("while dragged", _value_text(speed.pictures_per_second(), "{:.0f} pictures a second")),
        ("upload", _value_text(1e3 * upload_s or None, "{:.1f} ms, once a file")),
        ("memory", "unknown" if (held := resident_bytes()) is None else f"{held / 1e6:.0f} MB"),
        ("solver", renderer.solver.name),
    ]
    if picture is not None:
        settings, (width, height) = picture.settings, picture.texture.size
        quality = "" if settings.quality is Quality.PREVIEW else f", {settings.effective_quality}"
        quality_words = "whole" if picture.is_whole else f"preview{quality}"
        rows.insert(
            0, ("picture", f"{1e3 * picture.seconds:.0f} ms, {width}x{height}, {quality_words}")
        )
    _fact_rows(rows)
    watch = renderer.stopwatch
    is_on = widgets.check("time each pass", watch.is_on)
    if is_on != watch.is_on:
        watch.is_on = is_on
        watch.times.clear()
    _fact_rows([(name, f"{1e3 * timing.seconds:.1f} ms") for name, timing in watch.times.items()])


def _value_text(value: float | None, template: str) -> str:
    """Return a value formatted by a template, or a dash if it was not measured."""
    return _UNMEASURED if value is None else template.format(value)


def _fact_rows(rows: list[tuple[str, str]]) -> None:
    for label, value in rows:
        widgets.fact_row(label, value, f"speed {label}")
