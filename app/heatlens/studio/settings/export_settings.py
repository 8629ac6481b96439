"""The settings of an export, for the panel and for the exporting process."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.paths import folder_to_write_in
from heatlens.core.model.shot.settings import Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import NO_GUIDES, Guides
from heatlens.core.model.view.view import DisplayOptions
from heatlens.deliver.export.job import job_text
from heatlens.deliver.export.options import ExportOptions, options_in_panel
from heatlens.deliver.farm.export_place import HERE, ExportPlace
from heatlens.media.files.picture_formats import FORMATS

CAMERA_KINDS = {
    "USD": ".usda",
    "Nuke": ".nk",
    "Blender": ".py",
    "JSON": ".json",
    "table (CSV)": ".csv",
}
_LINEAR = "EXR (linear)"
_MOVIES = {"ProRes movie": ".mov", "H.264 movie": ".mp4"}


def frame_kinds() -> dict[str, str]:
    """Return the words for all that frames are exported to, with the suffix of each."""
    writable_formats = (file_format for file_format in FORMATS if file_format.writing)
    display_kinds = {
        f"{file_format.word} (as displayed)": file_format.suffixes[0]
        for file_format in writable_formats
    }
    return {_LINEAR: ".exr", **display_kinds, **_MOVIES}


@dataclass(frozen=True)
class ExportSettings(ExportOptions):
    """The export settings in the panel, with the options of every export.

    folder, name    the folder, and the name before the number of the frame
    quality         "" for that of the shot
    with_guides     the guides of the window are drawn into the pictures
    is_single       the shot has one frame, whose file needs no number unless frames are named
    place           who makes the frames
    """

    folder: str = ""
    name: str = ""
    kind: str = _LINEAR
    quality: str = ""
    with_guides: bool = False
    camera_kind: str = "USD"
    is_single: bool = False
    place: ExportPlace = HERE

    @property
    def output(self) -> str:
        """The path pattern of the frames, or the path of the movie."""
        suffix = frame_kinds()[self.kind]
        is_single = self.is_single and not self.frames
        number = "" if is_single or self.kind in _MOVIES else ".####"
        return str(Path(self.folder) / f"{self.name}{number}{suffix}")

    @property
    def camera_output(self) -> str:
        """The path of the camera file."""
        return str(Path(self.folder) / f"{self.name}{CAMERA_KINDS[self.camera_kind]}")

    @property
    def is_linear(self) -> bool:
        """True if the output is scene-linear and not made for a display."""
        return self.kind == _LINEAR

    def shot_at_quality(self, shot: Shot) -> Shot:
        """Return the shot at the quality of the export."""
        if not self.quality:
            return shot
        return replace(shot, defocus=replace(shot.defocus, quality=Quality(self.quality)))

    def job(self, look: DisplayOptions, guides: Guides = NO_GUIDES, shot: str = "") -> str:
        """Return the options as `heatlens export --job` reads them; EXR has no look, no guides.

        `shot` is the name of the shot in the burn-in.
        """
        options = ExportOptions(
            **{name: getattr(self, name) for name in options_in_panel(self.is_linear)}
        )
        if self.is_linear:
            return job_text(options)
        if guides.aspect is None:  # without a matte, its opacity is no option
            guides = replace(guides, opacity=NO_GUIDES.opacity)
        drawn_guides = guides if self.with_guides else NO_GUIDES
        return job_text(replace(options, shot_name=shot), look, drawn_guides)


def count_files(output: str) -> int:
    """Return how many files of an export are there: of its pattern of frames, or of its name."""
    path = Path(output).expanduser()
    name = re.escape(path.name).replace(re.escape("####"), r"-?\d{4,}")
    try:
        return sum(bool(re.fullmatch(name, file.name)) for file in path.parent.iterdir())
    except OSError:
        return 0  # the folder is not there, or cannot be listed


def proposed_settings(plate: Path, place: ExportPlace = HERE) -> ExportSettings:
    """Propose an export of a plate next to its file, under the same name, made at `place`.

    For files of the program, and in folders without write access, propose the user's pictures
    folder.
    """
    name = plate.name.split(".")[0]
    folder = str(folder_to_write_in(plate) / f"{name}_dof")
    return ExportSettings(folder, name, place=place)
