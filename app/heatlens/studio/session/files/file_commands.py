"""Open, reload and save files that the user names, and remember how they were read."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.messages import Worker
from heatlens.core.base.paths import folder_to_write_in, home_dir
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.documents.reel_file import REEL_SUFFIX, is_reel
from heatlens.media.sequence.depth_files import pair_picture_with_depth
from heatlens.media.sequence.folder_walk import ChosenFile
from heatlens.render.source.opened import Opened
from heatlens.studio.session.files.open_questions import DepthQuestion, NetworkQuestion
from heatlens.studio.session.files.open_reel import OpenReel
from heatlens.studio.session.files.plate_reading import PlateReading
from heatlens.studio.session.files.reel_editing import ReelEditing
from heatlens.studio.session.files.shot_documents import ShotDocuments
from heatlens.studio.session.files.shot_versions import Version
from heatlens.studio.session.lens.lens_imports import (
    FramingImport,
    camera_import,
    grade_import,
    opening_import,
)
from heatlens.studio.session.pictures.picture_commands import PictureCommands
from heatlens.studio.session.pictures.shot_reference import ShotReference
from heatlens.studio.session.pictures.view_commands import ReferenceLoader
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.settings.file_purposes import PURPOSES


class FileCommands(Commands, Worker):
    """The commands of the File menu; dialogs ask for the names."""

    def __init__(
        self,
        shared: Shared,
        documents: ShotDocuments,
        pictures: PictureCommands,
        references: ReferenceLoader,
        other_shot: ShotReference,
        reel: OpenReel,
        write_sheet: Callable[[Path, str], None],
        framing: FramingImport,
    ) -> None:
        super().__init__(shared)
        self._documents, self._pictures = documents, pictures
        self._references, self._other_shot = references, other_shot
        self._reel = reel
        self.reel_editing = ReelEditing(shared, reel, documents, self.open)
        self.reading = PlateReading(shared)
        self.no_depth = DepthQuestion(shared, self.open)
        self.unknown_network = NetworkQuestion(shared)
        self.openings = opening_import(shared)
        self.cameras, self.grades = camera_import(shared), grade_import(shared)
        self._write_sheet, self._framing = write_sheet, framing
        begin_functions = self.cameras.begin, self.grades.begin, framing.begin
        self._begin_import = dict(zip(("camera", "grade", "framing"), begin_functions, strict=True))

    @property
    def has_question(self) -> bool:
        """True while the user is asked about a source that could not be opened."""
        return bool(self.no_depth.name or self.unknown_network.name)

    # Opening

    def open(self, text: str, options: PlateOptions | None = None) -> None:
        """Open a file, pattern, folder or shot; the present source stays until it has arrived."""
        self._notify("")  # clear the error of an earlier file
        if not (self._reel.try_open(text) or self._documents.try_open(text)):
            plate_options = options or self.options_for(text)
            self._source.opener.open(text, plate_options, timing=self._command_line.timing_of(text))

    def open_first(self) -> None:
        """Open the file that the command line named, if any."""
        text = self._command_line.start.source
        given_options = self._command_line.start.plate_options
        if not text or self._reel.try_open(text) or self._documents.try_open(text):
            return
        is_stream = self._source.stream is not None and text == self._source.stream.text
        options = (
            given_options if is_stream else self._given_or_remembered_options(text, given_options)
        )
        self._source.opener.open(text, options, timing=self._command_line.timing_of(text))

    def open_dropped(self, names: Sequence[str]) -> None:
        """Add dropped files to the open reel; without one, open them as `open_named` does."""
        is_for_reel = self._reel.reel is not None and not any(map(is_reel, names))
        if is_for_reel and pair_picture_with_depth(names) is None:
            self.reel_editing.add(names)
        else:
            self.open_named(names)

    def open_named(self, names: Sequence[str]) -> None:
        """Open a picture with its depth file, if two names match; several shots as a new reel."""
        pair = pair_picture_with_depth(names)
        if pair is not None:
            picture, depth = pair
            self.open(picture, replace(self.options_for(picture), depth_source=depth))
        elif len(names) == 1 or self._reel.reel is not None:
            self.open(names[0])
        else:
            self.reel_editing.add(names)

    def options_for(self, text: str) -> PlateOptions:
        """Return the plate options for `text`: from the command line, or remembered.

        If the command line named no file, its options are for the first file that is opened.
        """
        is_first_file = not self._command_line.start.source and not self._command_line.has_opened
        given_options = self._command_line.start.plate_options if is_first_file else PlateOptions()
        return self._given_or_remembered_options(text, given_options)

    def _given_or_remembered_options(self, text: str, given_options: PlateOptions) -> PlateOptions:
        """Return the given options, or the remembered ones if none were given."""
        if replace(given_options, focal_length_mm=None, sensor_width_mm=None) != PlateOptions():
            return given_options
        remembered = self._preferences.options_for(text)
        return replace(
            remembered,
            focal_length_mm=given_options.focal_length_mm or remembered.focal_length_mm,
            sensor_width_mm=given_options.sensor_width_mm or remembered.sensor_width_mm,
        )

    def reload(self) -> None:
        """Read the plate or the scene again as it is on disk now, and notify the user."""
        opened = self._source.opened
        if opened is not None and opened.render_source is not None:
            framing = self._editing.shot.framing
            timing = None if framing is None else framing.timing
            self._source.opener.open(opened.text, opened.options, self._editing.frame, timing)
        elif opened is not None:
            self._notify(self._source.why_shown_once)

    # Choosing

    def may_choose(self, key: str) -> bool:
        """Return True if a file can be chosen for this purpose; report why not otherwise."""
        if self._source.plate is None and PURPOSES[key].is_save:
            self._notify("Nothing is open to save.")
        elif key == "behind" and not self.reading.is_possible:
            self._notify("Pictures behind belong to a plate, and none is open.")
        elif key == "save reel" and self._reel.reel is None:
            self._notify(self._reel.why_not)
        elif key == "save shot" and self._source.why_shown_once:
            self._notify(self._source.why_shown_once)
        else:
            return True
        return False

    def compare_with_version(self, version: Version) -> None:
        """Make an earlier version of the open shot side B."""
        self._other_shot.open(version.path, version.words)

    def first_folder(self, key: str) -> Path:
        """Return the folder in which a dialog begins: the last one used, or that of the plate.

        A shot is saved beside its file. For saving beside a plate of the program itself, the folder
        is the user's one of pictures.
        """
        shot_path = self._documents.path
        if key == "save shot" and shot_path is not None:
            return shot_path.parent
        plate, is_save = self._source.plate, PURPOSES[key].is_save
        if plate is None:
            folder = home_dir()
        else:
            folder = folder_to_write_in(plate.path) if is_save else plate.path.absolute().parent
        return Path(self._preferences.values.folders.get(key, folder))

    def first_name(self, key: str) -> str:
        """Return the file name that a save dialog proposes."""
        plate = self._source.plate
        if key == "save shot":
            return self._documents.proposed_name()
        if key == "save reel":
            return f"cut{REEL_SUFFIX}"
        if key == "sheet" and plate is not None:
            return f"{plate.path.name.split('.')[0]}.pull.html"
        return f"{plate.path.stem}.dof.exr" if plate is not None else ""

    def apply_choice(self, chosen_file: ChosenFile) -> None:
        """Open, import or write the file that was chosen in a dialog, by the dialog's purpose."""
        key, path = chosen_file.purpose.key, chosen_file.path
        frame_path = chosen_file.entry.file_at(self._editing.frame) if chosen_file.entry else path
        self._preferences.remember_folder(key, path.parent)
        match key:
            case "open" | "shot":
                self.open(str(path))
            case "reel shot":
                self.reel_editing.add([str(path)])
            case "save reel":
                self.reel_editing.save_as(path.absolute())
            case "compare shot":
                self._other_shot.open(path)
            case "reference":
                self._references.open(frame_path)
            case "depth":
                self.no_depth.use_file(path)
            case "media":
                self._reel.look_in(path.parent)
            case "network":
                self.no_depth.use_network(path)
            case "behind":
                self.reading.add_behind(chosen_file.entry, path)
            case "camera" | "grade" | "framing":
                self._begin_import[key](path)
            case "opening":
                self.openings.begin(frame_path)
            case "save shot":
                self._documents.save_as(path.absolute())
            case "sheet":
                title = self._documents.title.removesuffix(" *") or path.name.split(".")[0]
                self._write_sheet(path.absolute(), title)
            case _:
                self._pictures.save(path)

    # Called by the session

    def remember_opened(self, opened: Opened) -> None:
        """Remember an opened file."""
        self.reading.remember_options(opened)
        if opened.render_source is not None and opened.render_source.files is not None:
            self._preferences.remember_opened(opened.text)

    def poll(self) -> None:
        """Continue requested work; call this once a frame."""
        self.reading.reread_after_undo()
        self.reel_editing.poll()
        self._follow_stream()
        self.cameras.poll()
        self.grades.poll()
        self._framing.poll()
        self.openings.poll()

    def _follow_stream(self) -> None:
        """Read a stream as the Source panel says, or as the shot does after an undo.

        A recovered shot names its source as a path; that is replaced by the stream's name.
        """
        stream, reading, current_shot = self._source.stream, self.reading, self._editing.shot
        if stream is None or not stream.is_shown:
            return
        if reading.options == stream.options:
            reading.options = current_shot.plate_options
        stream.options = reading.options
        shot = replace(current_shot, source=stream.text, plate_options=stream.options)
        if shot != current_shot:
            self._editing.edit(shot)
