"""Files by hand: opening, saving and copying pictures, and what is remembered of it."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from imgui_bundle import imgui

from heatlens.background import Background
from heatlens.documents.shot_file import SHOT_SUFFIX
from heatlens.errors import InputError
from heatlens.files.picture_formats import PICTURES_READ
from heatlens.model.plate_options import PlateOptions
from heatlens.model.view import ViewState
from heatlens.paths import home_dir
from heatlens.plate.picture_write import PICTURE_SUFFIXES
from heatlens.preview.shown import Shown
from heatlens.scene.scene_read import SCENE_SUFFIXES
from heatlens.session.folder_walk import Chosen, Purpose
from heatlens.session.picture_saver import PictureSaver, Snapshot, snapshot
from heatlens.session.preferences import Preferences
from heatlens.source.kind import NO_FILES
from heatlens.source.named import source_named
from heatlens.source.opened import Opened
from heatlens.ui.files.camera_import import CameraImport
from heatlens.ui.files.file_browser import FileBrowser
from heatlens.ui.panels.exporter import Exporter
from heatlens.ui.panels.plate_reading import PlateReading

if TYPE_CHECKING:
    from heatlens.ui.app import App

PURPOSES = {
    purpose.key: purpose
    for purpose in (
        Purpose(
            "open",
            "Open a plate or a scene",
            "Open",
            (".exr", *PICTURES_READ, *SCENE_SUFFIXES),
            "# stands for the frame number.   A scene is a .glb, .gltf, .obj, .ply or .usd file.",
        ),
        Purpose("reference", "Open a reference", "Open", (".exr", *PICTURES_READ), "Shown as B."),
        Purpose(
            "save",
            "Save the picture",
            "Save",
            PICTURE_SUFFIXES,
            ".exr: scene-linear, with the lens in its header.   .png: as it looks here.",
            is_save=True,
        ),
        Purpose(
            "camera",
            "Take the lens of a camera",
            "Take",
            (".usd", ".usda", ".usdc", ".usdz", ".json", ".csv"),
            "Focal length, f-stop, focus and film back, with keys for what moves.",
        ),
        Purpose("shot", "Open a shot", "Open", (SHOT_SUFFIX,), "A shot and its plate."),
        Purpose(
            "save shot",
            "Save the shot",
            "Save",
            (SHOT_SUFFIX,),
            "Lens, keys, marks and how the plate is read; text that people can read.",
            is_save=True,
        ),
    )
}


class Filing:
    """What the File menu does."""

    def __init__(self, app: "App", preferences: Preferences, wake: Callable[[], None]) -> None:
        self._app = app
        self.preferences = preferences
        self.browser = FileBrowser(app.say, wake)
        self.saver = PictureSaver(app.say, wake)
        self.reading = PlateReading(app, preferences)
        self.exporter = Exporter(app, wake)
        self.cameras = CameraImport(app, wake)
        self.recent: tuple[str, ...] = ()  # those of the recent files that are there
        self._finder: Background[tuple[str, ...]] = Background(wake)

    # To begin with

    def first_view(self, given: ViewState) -> ViewState:
        """`given`, and where it says nothing what is remembered."""
        now = self.preferences.now
        if not given.display and not given.view:
            given = replace(given, display=now.display, view=now.view)
        return replace(given, unit=now.unit) if given.unit == ViewState().unit else given

    def begin(self, text: str, given: PlateOptions) -> None:
        """Open the first plate, if it is known, and show the panels that were shown."""
        app = self._app
        if text and not app.documents.opens(text):
            is_stream = app.source.stream is not None and text == app.source.stream.text
            app.source.open(text, given if is_stream else self._first_options(text, given))
        hidden = self.preferences.now.hidden_panels
        app.panels = {name: name not in hidden for name in app.panels}

    def options_for(self, text: str) -> PlateOptions:
        """Those of the command line, where it left open what to open; else what is remembered."""
        start = self._app.start
        is_given = not start.source and self._app.begun is None
        return self._first_options(text, start.plate_options if is_given else PlateOptions())

    def _first_options(self, text: str, given: PlateOptions) -> PlateOptions:
        """`given`, or where that says nothing of the plate what is remembered for its folder."""
        if replace(given, focal_length_mm=None, sensor_width_mm=None) != PlateOptions():
            return given
        kept = self.preferences.options_for(text)
        return replace(
            kept,
            focal_length_mm=given.focal_length_mm or kept.focal_length_mm,
            sensor_width_mm=given.sensor_width_mm or kept.sensor_width_mm,
        )

    # Choosing

    def browse(self, key: str) -> None:
        """Ask for a file."""
        plate = self._app.source.plate
        if plate is None and PURPOSES[key].is_save:
            self._app.say("Nothing is open that could be saved.")
            return
        if key == "save shot" and not self._app.source.is_repeatable:
            self._app.say(NO_FILES)
            return
        here = plate.path.absolute().parent if plate is not None else home_dir()
        folder = Path(self.preferences.now.folders.get(key, here))
        name = f"{plate.path.stem}.dof.exr" if plate is not None else ""
        if key == "save shot":
            name = self._app.documents.proposed_name()
        self.browser.open(PURPOSES[key], folder, name)

    def draw(self) -> None:
        """The dialog, where one is open; what is chosen in it is done."""
        chosen = self.browser.draw()
        if chosen is not None:
            self.preferences.looked_in(chosen.purpose.key, chosen.path.parent)
            self._take(chosen)

    def _take(self, chosen: Chosen) -> None:
        app, key = self._app, chosen.purpose.key
        if key in ("open", "shot"):
            app.open(str(chosen.path))
        elif key == "reference":
            at_frame = chosen.entry.file_at(app.editing.frame) if chosen.entry else chosen.path
            app.references.open(at_frame)
        elif key == "camera":
            self.cameras.begin(chosen.path)
        elif key == "save shot":
            app.documents.save_as(chosen.path.absolute())
        else:
            self.saver.ask(app.shot.source, app.editing.frame, chosen.path)

    def show_export(self) -> None:
        """Bring the panel to the front."""
        if not self._app.source.is_repeatable:
            self._app.say(NO_FILES)
        self._app.panels["Export"] = True
        imgui.set_window_focus("Export")

    def copy(self) -> None:
        """Put the picture on the clipboard."""
        if self._app.source.plate is None:
            self._app.say("Nothing is open that could be copied.")
        else:
            self.saver.ask(self._app.shot.source, self._app.editing.frame, None)

    def find_recent(self) -> None:
        """Look which of the recent files are there; `recent` tells a moment later.

        A renderer that is listened to leads them, so that it can be returned to.
        """
        stream, names = self._app.source.stream, self.preferences.now.recent
        first = () if stream is None else (stream.text,)
        self._finder.start(lambda: (*first, *(name for name in names if _is_there(name))))

    @property
    def is_looking(self) -> bool:
        """It is not known yet which recent files are there."""
        return self._finder.is_busy

    # What happens by itself

    def arrived(self, opened: Opened) -> None:
        """Remember what was opened; with the first one, say what could not be remembered."""
        self.reading.arrived(opened)
        if opened.source.files is not None:
            self.preferences.opened(opened.text)
        if self.preferences.problem:
            self._app.say(self.preferences.problem)
            self.preferences.problem = ""

    def poll(self) -> None:
        """Once a frame: go on with what is asked for."""
        app = self._app
        found = self._finder.poll()
        self.recent = self.recent if found is None else found
        self.reading.follow()
        self._follow_stream()
        self.exporter.poll()
        self.cameras.poll()
        whole = _whole(app)
        self.saver.poll(whole, app.shot.source, app.editing.frame, partial(_snap, app, whole))

    def _follow_stream(self) -> None:
        """Its frames are read as the Plate panel wishes, or as the shot does after an undo.

        A shot that was kept beside names its source as a path, and takes its name again.
        """
        app, stream, reading = self._app, self._app.source.stream, self.reading
        if stream is None or not stream.is_shown:
            return
        if reading.wished == stream.options:
            reading.wished = app.shot.plate_options
        stream.options = reading.wished
        shot = replace(app.shot, source=stream.text, plate_options=stream.options)
        if shot != app.shot:
            app.edit(shot)

    def remember(self, **window: object) -> None:
        """Keep what may have changed; `window` are further fields of Remembered."""
        app, view = self._app, self._app.view
        hidden = tuple(name for name, is_shown in app.panels.items() if not is_shown)
        playback = app.timeline.playback
        self.preferences.change(
            display=view.display,
            view=view.view,
            unit=view.unit,
            hidden_panels=hidden,
            ending=playback.ending,
            every_frame=playback.is_every_frame,
            **window,
        )
        try:
            self.preferences.save()
        except InputError as error:
            app.say(str(error))

    def close(self) -> None:
        """Finish the picture that is being written; stop an export, whose frames stay."""
        self.saver.close()
        self.exporter.run.close()


def _whole(app: "App") -> Shown | None:
    """The picture of the shot as it is now, once it is whole."""
    shown, source, frame = app.live.shown, app.source, app.editing.frame
    if source.plate is None or not (source.is_whole and source.is_settled_at(frame)):
        return None
    cache = app.timeline.cache
    if cache is not None and source.plate.path != cache.sequence.resolve(frame):
        return None  # the plate of the frame is still being read
    is_it = shown is not None and (shown.shot, shown.frame) == (app.shot, frame)
    return shown if is_it and not app.live.is_working else None


def _snap(app: "App", shown: Shown | None) -> Snapshot:
    """The picture, and the way it looks: view transform, exposure, gamma and the glass."""
    plate = app.source.plate
    assert shown is not None and plate is not None
    transform, view = app.color.transform, app.view
    stops = view.exposure_stops + app.lens.transmission_stops
    return snapshot(shown, plate, lambda light: transform.apply_cpu(light, stops, view.gamma))


def _is_there(text: str) -> bool:
    """On a thread: a file, a pattern or a folder can still be opened."""
    try:
        source_named(text).require()
    except InputError:
        return False
    return True
