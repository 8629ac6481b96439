"""Name the kinds of files that heatlens cannot read, by their extension, and the alternatives."""

from pathlib import Path

from heatlens.media.files.picture_formats import MOVIES_READ, suffixes_read

_PICTURES = "a picture of a kind that heatlens does not read: it reads {suffixes}"
_MOVIE = f"a movie of a kind that heatlens does not read: it reads {', '.join(MOVIES_READ)}"
_EDIT = (
    "an edit of a kind that heatlens does not read: it reads OpenTimelineIO (.otio), EDL (.edl), "
    "AAF (.aaf) and the XML of Final Cut Pro 7 (.xml), which most editors export"
)
_SCENE = (
    "a 3D scene of a kind that heatlens does not read: it reads glTF, USD, OBJ, PLY and STL, which "
    "most 3D programs export"
)
_WORDS = {
    **dict.fromkeys((".fcpxml", ".fcpxmld", ".fcp", ".prproj", ".drp", ".ale", ".otr"), _EDIT),
    **dict.fromkeys((".avi", ".wmv", ".flv", ".mpg", ".mpeg", ".ts", ".mts", ".m2ts"), _MOVIE),
    **dict.fromkeys((".ogv", ".r3d", ".braw", ".mxv", ".3gp"), _MOVIE),
    **dict.fromkeys((".gif", ".hdr", ".cin", ".hif", ".jxl", ".jp2", ".psd"), _PICTURES),
    **dict.fromkeys((".rat", ".tx", ".iff", ".sgi", ".cr2", ".cr3", ".nef", ".arw"), _PICTURES),
    **dict.fromkeys((".dng", ".svg", ".pdf", ".eps"), _PICTURES),
    **dict.fromkeys((".blend", ".fbx", ".abc", ".ma", ".mb", ".max", ".c4d", ".hip"), _SCENE),
    **dict.fromkeys((".hiplc", ".3ds", ".dae", ".skp", ".vdb"), _SCENE),
}


def describe_other_format(path: Path) -> str:
    """Return a phrase on a file of a kind that heatlens cannot read; "" for any other file.

    It says what the file is, and which kinds heatlens reads instead.
    """
    words = _WORDS.get(path.suffix.lower(), "")
    return words.format(suffixes=", ".join(suffixes_read()))
