"""Draw the Speed panel: pictures per second, time of each pass, memory and the GPU."""

from pathlib import Path

from imgui_bundle import imgui

from heatlens.model.shot.settings import Quality
from heatlens.preview.shown import Shown
from heatlens.render import FrameRenderer
from heatlens.session.loop.speed import Speed
from heatlens.ui import widgets

_UNMEASURED = "\N{EN DASH}"


def speed_panel(
    speed: Speed, upload_s: float, shown: Shown | None, renderer: FrameRenderer
) -> None:
    """Draw the panel; its checkbox switches the renderer's stopwatch."""
    imgui.text_disabled(str(renderer.ctx.info["GL_RENDERER"]))
    rows = [
        ("window", _text(speed.mean_ms(), "{:.1f} ms a frame")),
        ("while dragged", _text(speed.pictures_per_second(), "{:.0f} pictures a second")),
        ("upload", _text(1e3 * upload_s or None, "{:.1f} ms, once a file")),
        ("memory", f"{_resident_mb():.0f} MB"),
        ("solver", renderer.solver.name),
    ]
    if shown is not None:
        settings, (width, height) = shown.settings, shown.texture.size
        quality = "" if settings.quality is Quality.PREVIEW else f", {settings.quality}"
        whole = "whole" if shown.is_whole else f"preview{quality}"
        rows.insert(0, ("picture", f"{1e3 * shown.seconds:.0f} ms, {width}x{height}, {whole}"))
    _rows(rows)
    watch = renderer.stopwatch
    is_on = widgets.check("time each pass", watch.on)
    if is_on != watch.on:
        watch.on = is_on
        watch.times.clear()
    _rows([(name, f"{1e3 * t.seconds:.1f} ms") for name, t in watch.times.items()])


def _text(value: float | None, words: str) -> str:
    return _UNMEASURED if value is None else words.format(value)


def _rows(rows: list[tuple[str, str]]) -> None:
    for label, value in rows:
        widgets.fact(label, value, f"speed {label}")


def _resident_mb() -> float:
    """Return the resident memory of this process in MB; 0 if the system does not report it."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * 4096 / 1e6
