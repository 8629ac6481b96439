"""Where the time goes: pictures a second, milliseconds of each pass, memory, the GPU."""

from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

from imgui_bundle import imgui

from heatlens.preview.shown import Shown
from heatlens.render import FrameRenderer
from heatlens.ui import widgets

_KEPT = 30  # pictures and frames that the means are over
_UNMEASURED = "\N{EN DASH}"
_NEWEST = 0.2  # weight of the newest frame in a running mean


@dataclass
class Speed:
    """Times of the loop, the latest last."""

    frames_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    held_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    upload_s: float = 0.0
    window_s: float = 0.02  # running mean of drawing a frame without rendering its picture

    def frame(self, seconds: float, picture_s: float, is_held: bool) -> None:
        """A frame was drawn, `picture_s` of it for a picture that was new; 0 where none was."""
        self.frames_s.append(seconds)
        self.window_s += _NEWEST * (seconds - picture_s - self.window_s)
        if is_held and picture_s > 0:
            self.held_s.append(seconds)

    def mean_ms(self) -> float | None:
        """Of drawing a frame of the window; None before the first."""
        return 1e3 * sum(self.frames_s) / len(self.frames_s) if self.frames_s else None

    def pictures_per_second(self) -> float | None:
        """While something was dragged: new pictures on the screen. None before that."""
        return len(self.held_s) / sum(self.held_s) if self.held_s else None


def speed_panel(speed: Speed, shown: Shown | None, renderer: FrameRenderer) -> None:
    """Draw it; whether passes are timed is kept by the renderer's stopwatch."""
    imgui.text_disabled(str(renderer.ctx.info["GL_RENDERER"]))
    rows = [
        ("window", _told(speed.mean_ms(), "{:.1f} ms a frame")),
        ("while dragged", _told(speed.pictures_per_second(), "{:.0f} pictures a second")),
        ("upload", _told(1e3 * speed.upload_s or None, "{:.1f} ms, once a file")),
        ("memory", f"{_resident_mb():.0f} MB"),
        ("solver", renderer.solver.name),
    ]
    if shown is not None:
        settings, (width, height) = shown.settings, shown.texture.size
        whole = "whole" if shown.is_whole else f"preview, {settings.quality}"
        rows.insert(0, ("picture", f"{1e3 * shown.seconds:.0f} ms, {width}x{height}, {whole}"))
    _rows(rows)
    changed, on = imgui.checkbox("time each pass", renderer.stopwatch.on)
    if changed:
        renderer.stopwatch.on = on
        renderer.stopwatch.times.clear()
    times = renderer.stopwatch.times
    _rows([(name, f"{1e3 * t.seconds:.1f} ms") for name, t in times.items()])


def _told(value: float | None, words: str) -> str:
    return _UNMEASURED if value is None else words.format(value)


def _rows(rows: list[tuple[str, str]]) -> None:
    for label, value in rows:
        imgui.text_disabled(label)
        imgui.same_line(widgets.LABEL_EM * imgui.get_font_size())
        imgui.text(value)


def _resident_mb() -> float:
    """Memory of this process; 0 where the system does not tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * 4096 / 1e6
