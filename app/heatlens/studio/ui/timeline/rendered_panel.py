"""Show how many frames are rendered ahead, and a popup with their memory limits."""

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import InputError
from heatlens.render.rendered_frames.frame_store import MEGABYTE
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.settings.preferences import MEGABYTES_MOST
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.timeline.view import TimelineView

_POPUP = "Rendered frames"
_TIP = (
    "Frames under the blue bar are rendered and play at full rate. The others are rendered while\n"
    "the window is idle, from the playhead on; until then they are shown as a quick preview.\n"
    "Play > Rendered frames shows how much is kept."
)


def rendered_words(control: TimeControl) -> str:
    """Return the progress of rendering ahead, as text; "" if no frames are rendered ahead."""
    frames_ahead, is_playing = control.frames_ahead, bool(control.timeline.playback.direction)
    if not frames_ahead.wanted_count:
        return ""
    done_count, wanted_count = len(frames_ahead.progress.rendered_frames), frames_ahead.wanted_count
    prefix = "preview: " if is_playing and not frames_ahead.plays_cached_frames else ""
    if done_count == wanted_count and wanted_count == control.timeline.played.count:
        return f"all {wanted_count} frames rendered"
    return f"{prefix}{done_count} of {wanted_count} frames rendered"


def rendered_label(control: TimeControl) -> None:
    """Draw the progress as text in the current row."""
    words = rendered_words(control)
    if not words:
        return
    em, is_preview = imgui.get_font_size(), words.startswith("preview")
    count = (
        f"{len(control.frames_ahead.progress.rendered_frames)}/{control.frames_ahead.wanted_count}"
    )
    short_words = f"preview {count}" if is_preview else count
    imgui.same_line()
    width = imgui.get_content_region_avail().x - em
    fitting_words = next(
        (text for text in (words, short_words) if imgui.calc_text_size(text).x < width), ""
    )
    if not fitting_words:  # no second row, which would push the keys out; the blue bar shows it too
        imgui.new_line()
        return
    imgui.align_text_to_frame_padding()
    texts.colored_text(fitting_words, theme.colors.message if is_preview else theme.colors.dim)
    rects.note("progress of rendering ahead")
    texts.tooltip(_TIP)


def rendered_popup(control: TimeControl, view: TimelineView) -> None:
    """Draw the popup with the memory in use and its limits."""
    if view.opens_frames:
        view.opens_frames = False
        imgui.open_popup(_POPUP)
    screen = imgui.get_main_viewport()
    imgui.set_next_window_pos(screen.get_center(), imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    imgui.set_next_window_size(ImVec2(26 * imgui.get_font_size(), 0))
    if imgui.begin_popup(_POPUP):
        imgui.text("Rendered frames")
        _draw_facts(control)
        _draw_limits(control)
        _draw_buttons(control)
        imgui.end_popup()


def _draw_facts(control: TimeControl) -> None:
    """Draw the progress, the size of a frame, and how much memory and disk is used."""
    store, (width, height) = control.frames_ahead.store, control.frames_ahead.jobs.size
    lines = [rendered_words(control) or "no frames to play"]
    if control.frames_ahead.wanted_count:
        megabytes = control.frames_ahead.picture_bytes / MEGABYTE
        lines.append(f"each {width} x {height} pixels, {megabytes:.1f} MB: the size on the screen")
    lines.append(f"{_usage_text(store.memory.bytes_in_use, store.memory.limit_bytes)} of memory")
    if store.disk is not None:
        disk_usage = _usage_text(store.disk.bytes_in_use, store.disk.limit_bytes)
        lines.append(f"{disk_usage} on disk, in {store.disk.folder}")
    if store.problem:
        lines.append(store.problem)
    for line in lines:
        texts.colored_text(line, theme.colors.dim)
    widgets.spacer()


def _usage_text(used_bytes: int, limit_bytes: int) -> str:
    return f"{used_bytes / MEGABYTE:,.0f} of {limit_bytes / MEGABYTE:,.0f} MB"


def _draw_limits(control: TimeControl) -> None:
    """Draw the limits of memory and disk, and the switch of rendering ahead; apply changes."""
    preferences = control.frames_ahead.preferences
    widgets.label("memory", "Megabytes for rendered frames; empty: a quarter of the free memory")
    memory = _megabytes_field(
        "memory for frames", preferences.memory_mb, "a quarter of what is free", control
    )
    disk = preferences.disk_mb
    if control.frames_ahead.store.disk is not None:
        widgets.label("disk", "Megabytes for rendered frames; 0 keeps none on disk")
        disk = _megabytes_field("disk for frames", preferences.disk_mb, "0", control)
    widgets.label("render")
    words = "frames ahead while idle"
    if (
        widgets.check(words, preferences.keep_frames, "render frames ahead")
        != preferences.keep_frames
    ):
        control.frames_ahead.switch()
    if (memory, disk) != (preferences.memory_mb, preferences.disk_mb):
        control.frames_ahead.resize(memory, disk)


def _megabytes_field(name: str, value: int, hint: str, control: TimeControl) -> int:
    """Draw a field for a limit in megabytes; return the value. Empty text means 0."""
    value_text = f"{value} MB" if value else ""
    return widgets.text_field(name, value_text, value, _parse_megabytes, control.notify, hint)


def _parse_megabytes(text: str) -> int:
    """Parse an amount in MB, or in GB if the text has that unit; an empty text is 0."""
    amount = text.strip().lower().replace(",", ".").removesuffix("b").strip()
    factor = 1000 if amount.endswith("g") else 1
    try:
        count = float(amount.rstrip("gm").strip() or 0) * factor
    except ValueError:
        raise InputError(f"{text!r} is not an amount of memory. Example: 2000 or 2 GB.") from None
    if not 0 <= count <= MEGABYTES_MOST:
        raise InputError(f"{text!r} should be 0 to {MEGABYTES_MOST:,} MB.")
    return round(count)


def _draw_buttons(control: TimeControl) -> None:
    """Draw the buttons that clear all frames and close the popup."""
    if widgets.button("Clear", "clear frames"):
        control.frames_ahead.clear()
    imgui.same_line()
    if widgets.button("Close", "close rendered frames"):
        imgui.close_current_popup()
