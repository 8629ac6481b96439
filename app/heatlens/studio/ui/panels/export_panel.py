"""Draw the Export panel: frames, movies, and the lens as a camera file."""

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.settings import Quality
from heatlens.deliver.export.options import ExportOptions, in_panel
from heatlens.deliver.farm.connection import checked_address
from heatlens.studio.session.exports.export_commands import ExportCommands
from heatlens.studio.session.exports.export_process import ExportState
from heatlens.studio.session.exports.export_settings import (
    CAMERA_KINDS,
    ExportSettings,
    frame_kinds,
)
from heatlens.studio.session.playing.cluster_frames import ClusterFrames
from heatlens.studio.session.settings.export_place import ExportPlace, Where
from heatlens.studio.ui import probe, texts, theme, widgets
from heatlens.studio.ui.field_row import field_row

_PROCESSES = (1, 2, 4, 8, 16)
_AHEAD_TIP = "Workers render the frames of the shot while the window rests, for playback."
_AT_REST_TIP = (
    "A worker renders the whole picture once the hand rests, for example one with a GPU; the\n"
    "small pictures while something moves are rendered here."
)
_QUALITY_TIP = (
    "Plates are exported at final if nobody names a quality. Where many surfaces behind the focus\n"
    "are known it takes five times as long as film or more; elsewhere both are the same. Once the\n"
    "export runs, the time of both is told here."
)


class Pressed(StrEnum):
    """The button of the panel that was pressed."""

    NOTHING = "nothing"
    EXPORT = "export"
    CAMERA = "camera"
    CANCEL = "cancel"
    AGREE = "agree"


def draw_exports(exports: ExportCommands, cluster: ClusterFrames) -> None:
    """Draw the panel in the current window and do what its buttons ask for."""
    exports.propose()
    settings, pressed = export_panel(
        exports.settings,
        exports.played,
        exports.run.state,
        cluster.told,
        exports.say,
        exports.usual_quality,
        cluster.asks,
    )
    exports.change(settings)
    if pressed is Pressed.AGREE:
        cluster.agree()
    elif pressed is Pressed.CANCEL:
        exports.run.cancel()
    elif pressed is Pressed.EXPORT:
        exports.export()
    elif pressed is Pressed.CAMERA:
        exports.write_camera()


def export_panel(
    settings: ExportSettings,
    played: FrameRange | None,
    state: ExportState | None,
    workers: str = "",
    say: Callable[[str], None] = lambda _: None,
    usual: Quality = Quality.FINAL,
    asks: bool = False,
) -> tuple[ExportSettings, Pressed]:
    """Draw the panel; return the settings as the user left them, and the button pressed.

    `workers` tells how many workers of a cluster render for this window, `usual` is the quality if
    none is chosen here. `asks` is true while its scheduler is not one that the user agreed to.
    """
    imgui.separator_text("Frames")
    settings = replace(_folder(settings), place=_place(settings.place, workers, say))
    pressed = _agreement(asks and settings.place.where is Where.CLUSTER)
    settings = replace(settings, kind=widgets.choice("as", settings.kind, list(frame_kinds())))
    settings = _options(settings, played, usual)
    is_busy = state is not None and state.code is None
    with widgets.disabled(is_busy or not settings.name or not settings.folder):
        if widgets.button("Write job" if settings.place.is_job else "Export", "Export"):
            pressed = Pressed.EXPORT
    imgui.same_line()
    place, output = settings.place, settings.output
    imgui.text_disabled(printable(place.job_name(output) if place.is_job else Path(output).name))
    if state is not None and _progress(state):
        pressed = Pressed.CANCEL
    imgui.separator_text("Lens as a camera")
    settings = replace(
        settings, camera_kind=widgets.choice("for", settings.camera_kind, list(CAMERA_KINDS))
    )
    with widgets.disabled(is_busy or not settings.name or not settings.folder):
        if widgets.button("Write camera", "Write camera"):
            pressed = Pressed.CAMERA
    imgui.same_line()
    imgui.text_disabled(printable(Path(settings.camera_output).name))
    return settings, pressed


def _place(place: ExportPlace, workers: str, say: Callable[[str], None]) -> ExportPlace:
    """Draw who makes the frames."""
    tip = "A job is saved beside the frames, with its shot; a farm or a cluster makes them later."
    place = replace(place, where=widgets.pick_one("where", place.where, tip))
    if place.where is Where.HERE:
        counts = {count: str(count) for count in sorted({*_PROCESSES, place.processes})}
        tip = "Several use a machine with many processors better."
        return replace(place, processes=widgets.pick("processes", place.processes, counts, tip))
    return _cluster(place, workers, say) if place.where is Where.CLUSTER else place


def _cluster(place: ExportPlace, workers: str, say: Callable[[str], None]) -> ExportPlace:
    """Draw the address of a cluster, and what else it renders for the window."""
    widgets.label("scheduler", "Address of `dask scheduler`, such as tcp://192.168.1.20:8786.")
    now = place.scheduler
    scheduler = widgets.text_field("export scheduler", now, now, checked_address, say)
    widgets.label("renders too", "Pictures that the window shows, as well as exports.")
    ahead = widgets.check("frames ahead (the blue bar)", place.ahead, tip=_AHEAD_TIP)
    widgets.label("")
    at_rest = widgets.check("the picture at rest", place.at_rest, tip=_AT_REST_TIP)
    if workers:
        widgets.label("")
        texts.colored_text(workers, theme.colors.dim)
    return replace(place, scheduler=scheduler, ahead=ahead, at_rest=at_rest)


def _agreement(asks: bool) -> Pressed:
    """Draw the button with which the user agrees to a scheduler, while one asks for it."""
    if not asks:
        return Pressed.NOTHING
    widgets.label("")
    is_pressed = widgets.button("Use this scheduler", "agree")
    texts.tip_above(
        "It and its workers get the names of your files and send pictures. The window asks again\n"
        "when another scheduler answers, or this machine is in another network."
    )
    return Pressed.AGREE if is_pressed else Pressed.NOTHING


def _folder(settings: ExportSettings) -> ExportSettings:
    widgets.label("folder", "Created if it does not exist.")
    folder = widgets.typed("export folder", settings.folder)
    widgets.label("name", "Followed by the frame number and the extension.")
    return replace(settings, folder=folder, name=widgets.typed("export name", settings.name))


def _options(settings: ExportSettings, played: FrameRange | None, usual: Quality) -> ExportSettings:
    span = "one frame" if played is None or played.count == 1 else f"{played}, from in to out"
    option = options_of(ExportOptions)["frames"]
    widgets.label(option.label, option.tip)
    _, frames = imgui.input_text_with_hint("##export frames", span, settings.frames)
    probe.note("export frames")
    words = {"": f"as the shot: {usual}"} | {str(quality): str(quality) for quality in Quality}
    quality = widgets.pick("at quality", settings.quality, words, _QUALITY_TIP)
    settings = replace(settings, frames=frames.strip(), quality=quality)
    for name in in_panel(settings.is_linear):
        if name != "frames":
            settings = field_row(settings, name)
    if settings.is_linear:
        return settings
    with_guides = widgets.check("guides and desqueeze of the window", settings.with_guides)
    texts.tip_above("Draws the guides of the Guides tab into the files too.")
    return replace(settings, with_guides=with_guides)


def _progress(state: ExportState) -> bool:
    """Draw the progress or the result of the export; return True if Stop was pressed."""
    widgets.spacer()
    if state.code is None:
        part = state.done / state.frames if state.frames else 0.0
        left = "" if state.left_s is None else f", {state.left_s:.0f} s left"
        words = f"{state.done} of {state.frames}{left}" if state.frames else "starting ..."
        imgui.progress_bar(part, ImVec2(-5 * imgui.get_font_size(), 0), words)
        imgui.same_line()
        is_stopped = widgets.button("Stop", "Stop")
        if state.pace:
            texts.colored_text(state.pace, theme.colors.dim)
        _by_worker(state)
        return is_stopped
    texts.colored_text(state.said, theme.colors.dim if state.code == 0 else theme.colors.bad)
    return False


def _by_worker(state: ExportState) -> None:
    """Draw which share of the frames each worker of a cluster has made."""
    if not state.made_by:
        return
    if state.earlier:
        imgui.text_disabled(f"{state.earlier} finished before, then by worker:")
    for worker, count in sorted(state.made_by.items()):
        name = printable(worker.rpartition("/")[2])
        imgui.progress_bar(count / state.frames, ImVec2(-1, 0), f"{name}:  {count}")
