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
from heatlens.deliver.export.options import ExportOptions, options_in_panel
from heatlens.deliver.farm.connection import parse_address
from heatlens.deliver.farm.export_place import ExportPlace, Where
from heatlens.deliver.farm.export_process import ExportState
from heatlens.studio.board.controls import FileControl, PictureControl
from heatlens.studio.settings.export_settings import (
    CAMERA_KINDS,
    ExportSettings,
    frame_kinds,
)
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.field_row import field_row

_FARM_ROWS = ("where", "processes", "scheduler", "renders too")
_OVERWRITE = "overwrite"
_PROCESSES = (1, 2, 4, 8, 16)
_AHEAD_TIP = "Workers render the frames of the shot while the window rests, for playback."
_AT_REST_TIP = (
    "A worker renders the whole picture once the hand rests, for example one with a GPU; the\n"
    "small pictures while something moves are rendered here."
)
_QUALITY_TIP = (
    "Plates are exported at final if nobody names a quality. Where many surfaces are\n"
    "known it takes several times as long as film; elsewhere both are the same. Once the export\n"
    "runs, the time of both is told here."
)


class PressedButton(StrEnum):
    """The button of the panel that was pressed."""

    NOTHING = "nothing"
    EXPORT = "export"
    CAMERA = "camera"
    CANCEL = "cancel"


def draw_exports(files: FileControl, pictures: PictureControl) -> None:
    """Draw the panel in the current window, and run the command of a pressed button."""
    exports = files.exports
    exports.propose()
    settings, pressed = export_panel(
        exports.settings,
        exports.played,
        exports.run.state,
        pictures.cluster.status_text,
        exports.notify,
        exports.usual_quality,
        exports.shown_quality,
    )
    exports.change(settings)
    if pressed is PressedButton.CANCEL:
        exports.run.cancel()
    elif pressed is PressedButton.EXPORT:
        exports.request_export()
    elif pressed is PressedButton.CAMERA:
        exports.write_camera()


def export_panel(
    settings: ExportSettings,
    played: FrameRange | None,
    state: ExportState | None,
    workers: str = "",
    notify: Callable[[str], None] = lambda _: None,
    default_quality: Quality = Quality.FINAL,
    shown_quality: Quality = Quality.FILM,
) -> tuple[ExportSettings, PressedButton]:
    """Draw the panel; return the settings as the user left them, and the button pressed.

    `workers` is a text about the workers of a cluster that render for this window.
    `default_quality` is used if no quality is chosen here; `shown_quality` is that of the window.
    """
    imgui.separator_text("Frames")
    settings, pressed = _folder_rows(settings), PressedButton.NOTHING
    settings = replace(settings, kind=widgets.choice("format", settings.kind, list(frame_kinds())))
    settings = _option_rows(settings, played, (default_quality, shown_quality))
    is_busy = state is not None and state.code is None
    with widgets.disabled(is_busy or not settings.name or not settings.folder):
        if widgets.button("Write job" if settings.place.is_job else "Export", "Export"):
            pressed = PressedButton.EXPORT
    imgui.same_line()
    place, output = settings.place, settings.output
    imgui.text_disabled(printable(place.job_name(output) if place.is_job else Path(output).name))
    if state is not None and _draw_progress(state):
        pressed = PressedButton.CANCEL
    if widgets.folded_header("Farm", _FARM_ROWS, place.where is not Where.HERE):
        settings = replace(settings, place=_place_rows(place, workers, notify))
    settings, is_camera_pressed = _camera_rows(settings, is_busy)
    return settings, PressedButton.CAMERA if is_camera_pressed else pressed


def _camera_rows(settings: ExportSettings, is_busy: bool) -> tuple[ExportSettings, bool]:
    """Draw the kind of camera file; return the settings, and whether its button was pressed."""
    imgui.separator_text("Camera file")
    kind = widgets.choice("for", settings.camera_kind, list(CAMERA_KINDS))
    settings = replace(settings, camera_kind=kind)
    with widgets.disabled(is_busy or not settings.name or not settings.folder):
        is_pressed = widgets.button("Write camera", "Write camera")
    imgui.same_line()
    imgui.text_disabled(printable(Path(settings.camera_output).name))
    return settings, is_pressed


def _place_rows(place: ExportPlace, workers: str, notify: Callable[[str], None]) -> ExportPlace:
    """Draw the choice of who makes the frames; return the place as the user left it."""
    tip = "A job is saved beside the frames, with its shot; a farm or a cluster makes them later."
    place = replace(place, where=widgets.pick_one("where", place.where, tip))
    if place.where is Where.HERE:
        counts = {count: str(count) for count in sorted({*_PROCESSES, place.processes})}
        tip = "Several use a machine with many processors better."
        return replace(place, processes=widgets.pick("processes", place.processes, counts, tip))
    return _cluster_rows(place, workers, notify) if place.where is Where.CLUSTER else place


def _cluster_rows(place: ExportPlace, workers: str, notify: Callable[[str], None]) -> ExportPlace:
    """Draw the address of a cluster, and which pictures of the window it renders too."""
    widgets.label("scheduler", "Address of `dask scheduler`, such as tcp://192.168.1.20:8786.")
    address = place.scheduler
    scheduler = widgets.text_field("export scheduler", address, address, parse_address, notify)
    widgets.label("renders too", "Pictures that the window shows, as well as exports.")
    ahead = widgets.check("frames ahead (the blue bar)", place.ahead, tip=_AHEAD_TIP)
    widgets.label("")
    at_rest = widgets.check("the picture at rest", place.at_rest, tip=_AT_REST_TIP)
    if workers:
        widgets.label("")
        texts.colored_text(workers, theme.colors.dim)
    return replace(place, scheduler=scheduler, ahead=ahead, at_rest=at_rest)


def _folder_rows(settings: ExportSettings) -> ExportSettings:
    """Draw the fields of folder and name, and what may be overwritten there."""
    widgets.label("folder", "Created if it does not exist.")
    folder = widgets.typed_text("export folder", settings.folder)
    widgets.label("name", "Followed by the frame number and the extension.")
    name = widgets.typed_text("export name", settings.name)
    return field_row(replace(settings, folder=folder, name=name), _OVERWRITE)


def difference_from_window(exported: Quality, shown: Quality) -> str:
    """Return in words how an export differs from the picture of the window; "" if it does not."""
    return "" if exported is shown else f"The window shows {shown}; Q changes that."


def _option_rows(
    settings: ExportSettings, played: FrameRange | None, qualities: tuple[Quality, Quality]
) -> ExportSettings:
    """Draw frames, quality and the options of the format; return the changed settings.

    `qualities` are the default one and that of the window.
    """
    default_quality, shown_quality = qualities
    span = "one frame" if played is None or played.count == 1 else f"{played}, from in to out"
    option = options_of(ExportOptions)["frames"]
    widgets.label(option.label, option.tip)
    _, frames = imgui.input_text_with_hint("##export frames", span, settings.frames)
    rects.note("export frames")
    quality_names = {"": f"as the shot: {default_quality}"} | {
        str(quality): str(quality) for quality in Quality
    }
    quality = widgets.pick("quality", settings.quality, quality_names, _QUALITY_TIP)
    if words := difference_from_window(Quality(quality or default_quality), shown_quality):
        imgui.text_disabled(words)
    settings = replace(settings, frames=frames.strip(), quality=quality)
    for name in options_in_panel(settings.is_linear):
        if name not in ("frames", _OVERWRITE):
            settings = field_row(settings, name)
    if settings.is_linear:
        return settings
    with_guides = widgets.check("guides and desqueeze of the window", settings.with_guides)
    texts.tip_above("Draws the frame mask and the guides of the Display tab into the files too.")
    return replace(settings, with_guides=with_guides)


def _draw_progress(state: ExportState) -> bool:
    """Draw the progress or the result of the export; return True if Stop was pressed."""
    widgets.spacer()
    if state.code is None:
        share = state.done_frames / state.frames if state.frames else 0.0
        remaining = "" if state.remaining_s is None else f", {state.remaining_s:.0f} s left"
        progress_words = (
            f"{state.done_frames} of {state.frames}{remaining}" if state.frames else "starting ..."
        )
        imgui.progress_bar(share, ImVec2(-5 * imgui.get_font_size(), 0), progress_words)
        imgui.same_line()
        is_stopped = widgets.button("Stop", "Stop")
        if state.pace:
            texts.colored_text(state.pace, theme.colors.dim)
        _draw_worker_shares(state)
        return is_stopped
    texts.colored_text(
        state.last_sentence, theme.colors.dim if state.code == 0 else theme.colors.bad
    )
    return False


def _draw_worker_shares(state: ExportState) -> None:
    """Draw the share of the frames that each worker of a cluster has made."""
    if not state.frames_by_worker:
        return
    if state.earlier_frames:
        imgui.text_disabled(f"{state.earlier_frames} finished before, then by worker:")
    for worker, count in sorted(state.frames_by_worker.items()):
        name = printable(worker.rpartition("/")[2])
        imgui.progress_bar(count / state.frames, ImVec2(-1, 0), f"{name}:  {count}")
