"""What the user wants to export, as the panel shows it and as the command line takes it."""

from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.model.guides import NO_GUIDES, Guides
from heatlens.model.look_options import LookOptions
from heatlens.model.option import words_of
from heatlens.paths import folder_to_write_in

FRAME_KINDS = {
    "EXR, scene-linear": ".exr",
    "PNG, as it looks": ".png",
    "JPEG, as it looks": ".jpg",
    "TIFF, as it looks": ".tif",
    "ProRes movie": ".mov",
    "H.264 movie": ".mp4",
}
CAMERA_KINDS = {
    "USD": ".usda",
    "Nuke": ".nk",
    "Blender": ".py",
    "JSON": ".json",
    "table (CSV)": ".csv",
}
_MOVIES = (".mov", ".mp4")


@dataclass(frozen=True)
class ExportSettings:
    """What is to be exported, as the panel shows it.

    folder, name    where to, and the name before the number of the frame
    frames          range as text, "" for all from in to out
    quality         "" for that of the shot
    with_guides     the guides of the window are drawn into the pictures
    overwrite       replace files too that no export wrote
    is_single       the shot has one frame, whose file needs no number unless frames are named
    """

    folder: str = ""
    name: str = ""
    kind: str = "EXR, scene-linear"
    frames: str = ""
    quality: str = ""
    with_depth: bool = False
    burn_in: bool = False
    with_guides: bool = False
    overwrite: bool = False
    camera_kind: str = "USD"
    is_single: bool = False

    @property
    def output(self) -> str:
        """The path pattern of the frames, or the path of the movie."""
        suffix = FRAME_KINDS[self.kind]
        is_single = self.is_single and not self.frames
        number = "" if is_single or suffix in _MOVIES else ".####"
        return str(Path(self.folder) / f"{self.name}{number}{suffix}")

    @property
    def camera_output(self) -> str:
        """The path of the camera file."""
        return str(Path(self.folder) / f"{self.name}{CAMERA_KINDS[self.camera_kind]}")

    @property
    def is_linear(self) -> bool:
        """Return True if the output is scene-linear and not made for a display."""
        return FRAME_KINDS[self.kind] == ".exr"

    def words(self, look: LookOptions, guides: Guides = NO_GUIDES) -> list[str]:
        """Return the options of `heatlens export`. EXR output ignores the look and the guides."""
        words = ["--frames", self.frames] if self.frames else []
        words += ["--quality", self.quality] if self.quality else []
        words += ["--overwrite"] if self.overwrite else []
        if self.is_linear:
            return [*words, "--with-depth"] if self.with_depth else words
        words += words_of(look)
        words += words_of(replace(guides, opacity=_opacity(guides))) if self.with_guides else []
        return [*words, "--burn-in"] if self.burn_in else words


def _opacity(guides: Guides) -> float:
    """Return the opacity of the matte; the default if there is none."""
    return NO_GUIDES.opacity if guides.aspect is None else guides.opacity


def proposed_settings(plate: Path) -> ExportSettings:
    """Propose an export of a plate next to its file, under the same name.

    What comes with the program, or lies where nothing may be written, goes to the user's pictures.
    """
    name = plate.name.split(".")[0]
    return ExportSettings(str(folder_to_write_in(plate) / f"{name}_dof"), name)
