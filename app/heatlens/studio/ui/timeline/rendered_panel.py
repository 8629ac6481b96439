"""Show how many frames are rendered ahead, and a popup with their memory limits."""

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import InputError
from heatlens.render.rendered_frames.frame_store import MEGABYTE
from heatlens.studio.session.desks import TimeDesk
from heatlens.studio.session.settings.preferences import MEGABYTES_MOST
from heatlens.studio.ui import texts, theme, widgets
from heatlens.studio.ui.timeline.view import TimelineView

_POPUP = "Rendered frames"
_TIP = (
    "Frames under the blue bar are rendered and play at full rate. The others are rendered while\n"
    "the window is idle, from the playhead on; until then they are shown as a quick preview.\n"
    "Click to see how much is kept."
)


def rendered_words(desk: TimeDesk) -> str:
    """Return the progress of rendering ahead, as text; "" if no frames are rendered ahead."""
    pull, playing = desk.pull, bool(desk.timeline.playback.direction)
    if not pull.wanted:
        return ""
    done, wanted = len(pull.progress.rendered), pull.wanted
    shown = "preview: " if playing and not pull.is_alone else ""
    if done == wanted and wanted == desk.timeline.played.count:
        return f"all {wanted} frames rendered"
    return f"{shown}{done} of {wanted} frames rendered"


def rendered_label(desk: TimeDesk, view: TimelineView) -> None:
    """Draw the progress text as a button in the current row."""
    words = rendered_words(desk)
    if not words:
        return
    em, is_preview = imgui.get_font_size(), words.startswith("preview")
    count = f"{len(desk.pull.progress.rendered)}/{desk.pull.wanted}"
    short = f"preview {count}" if is_preview else count
    imgui.same_line()
    room = imgui.get_content_region_avail().x - em
    shown = next((it for it in (words, short) if imgui.calc_text_size(it).x < room), "")
    if not shown:  # another row would push the keys out of the panel, and the blue bar shows it too
        imgui.new_line()
        return
    imgui.push_style_color(imgui.Col_.button, theme.NOTHING)
    imgui.push_style_var(imgui.StyleVar_.frame_border_size, 0.0)
    with texts.colored(theme.colors.told if is_preview else theme.colors.dim):
        pressed = widgets.button(f"{shown}###rendered frames", "rendered frames")
    imgui.pop_style_var()
    imgui.pop_style_color()
    texts.tooltip(_TIP)
    if pressed:
        view.open_frames()


def rendered_popup(desk: TimeDesk, view: TimelineView) -> None:
    """Draw the popup with the memory in use and its limits."""
    if view.opens_frames:
        view.opens_frames = False
        imgui.open_popup(_POPUP)
    screen = imgui.get_main_viewport()
    imgui.set_next_window_pos(screen.get_center(), imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    imgui.set_next_window_size(ImVec2(26 * imgui.get_font_size(), 0))
    if imgui.begin_popup(_POPUP):
        imgui.text("Rendered frames")
        _facts(desk)
        _limits(desk)
        _buttons(desk)
        imgui.end_popup()


def _facts(desk: TimeDesk) -> None:
    store, (width, height) = desk.pull.store, desk.pull.jobs.size
    lines = [rendered_words(desk) or "no frames to play"]
    if desk.pull.wanted:
        megabytes = desk.pull.picture_bytes / MEGABYTE
        lines.append(f"each {width} x {height} pixels, {megabytes:.1f} MB: the size on the screen")
    lines.append(f"{_used(store.memory.bytes_in_use, store.memory.limit_bytes)} of memory")
    if store.disk is not None:
        used = _used(store.disk.bytes_in_use, store.disk.limit_bytes)
        lines.append(f"{used} on disk, in {store.disk.folder}")
    if store.problem:
        lines.append(store.problem)
    for line in lines:
        texts.colored_text(line, theme.colors.dim)
    widgets.spacer()


def _used(used: int, limit: int) -> str:
    return f"{used / MEGABYTE:,.0f} of {limit / MEGABYTE:,.0f} MB"


def _limits(desk: TimeDesk) -> None:
    before = desk.pull.kept
    widgets.label("memory", "Megabytes for rendered frames; empty: a quarter of the free memory")
    memory = _megabytes("memory for frames", before.memory_mb, "a quarter of what is free", desk)
    disk = before.disk_mb
    if desk.pull.store.disk is not None:
        widgets.label("disk", "Megabytes for rendered frames; 0 keeps none on disk")
        disk = _megabytes("disk for frames", before.disk_mb, "0", desk)
    widgets.label("render")
    words = "frames ahead while idle"
    if widgets.check(words, before.keep_frames, "render frames ahead") != before.keep_frames:
        desk.pull.switch()
    if (memory, disk) != (before.memory_mb, before.disk_mb):
        desk.pull.resize(memory, disk)


def _megabytes(name: str, value: int, hint: str, desk: TimeDesk) -> int:
    shown = f"{value} MB" if value else ""
    return widgets.text_field(name, shown, value, _parse_megabytes, desk.say, hint)


def _parse_megabytes(text: str) -> int:
    """Parse an amount in MB, or in GB if the text says so; an empty text is 0."""
    cleaned = text.strip().lower().replace(",", ".").removesuffix("b").strip()
    times = 1000 if cleaned.endswith("g") else 1
    try:
        count = float(cleaned.rstrip("gm").strip() or 0) * times
    except ValueError:
        raise InputError(f"{text!r} is not an amount of memory. Example: 2000 or 2 GB.") from None
    if not 0 <= count <= MEGABYTES_MOST:
        raise InputError(f"{text!r} should be 0 to {MEGABYTES_MOST:,} MB.")
    return round(count)


def _buttons(desk: TimeDesk) -> None:
    if widgets.button("Clear", "clear frames"):
        desk.pull.clear()
    imgui.same_line()
    if widgets.button("Close", "close rendered frames"):
        imgui.close_current_popup()
