"""What the file dialogs ask for, and the endings that they list."""

from heatlens.media.color.grade_file import GRADE_SUFFIXES
from heatlens.media.documents.frame_line_file import FDL_SUFFIX
from heatlens.media.documents.reel_file import REEL_SUFFIX, REEL_SUFFIXES
from heatlens.media.documents.shot_file import SHOT_SUFFIX
from heatlens.media.files.picture_formats import MOVIES_READ, suffixes_read, suffixes_written
from heatlens.media.scene.scene_read import SCENE_SUFFIXES
from heatlens.media.sequence.folder_walk import Purpose

PURPOSES = {
    purpose.key: purpose
    for purpose in (
        Purpose(
            "open",
            "Open a plate or a scene",
            "Open",
            (*MOVIES_READ, *SCENE_SUFFIXES, *REEL_SUFFIXES),
            "# stands for the frame number.   A scene is a .glb, .gltf, .obj, .ply or .usd file.",
            pictures=suffixes_read,
        ),
        Purpose(
            "reel shot",
            "Add shots to the reel",
            "Add",
            (*MOVIES_READ, *SCENE_SUFFIXES, SHOT_SUFFIX),
            "Shots, plates and scenes, one after the other; Escape when all are there.",
            pictures=suffixes_read,
            stays=True,
        ),
        Purpose(
            "depth",
            "Choose the depth of the picture",
            "Take",
            MOVIES_READ,
            "A picture or a movie whose grey is the depth, or an EXR with a channel of it.",
            pictures=suffixes_read,
        ),
        Purpose(
            "media",
            "Choose one of the missing files",
            "Take",
            MOVIES_READ,
            "The other missing shots of the cut are looked for in its folder too.",
            pictures=suffixes_read,
        ),
        Purpose(
            "network",
            "Choose a network that estimates the depth",
            "Take",
            (".onnx",),
            "It runs on this machine. Depth is estimated for each frame.",
        ),
        Purpose(
            "behind",
            "Add a picture of what lies behind",
            "Add",
            (),
            "It needs depth and the same camera: a clean plate, or a character with alpha.",
            pictures=suffixes_read,
        ),
        Purpose(
            "reference",
            "Open a reference",
            "Open",
            (),
            "Shown as B.",
            pictures=suffixes_read,
        ),
        Purpose(
            "compare shot",
            "Compare with a shot",
            "Compare",
            (SHOT_SUFFIX,),
            "Shown as B: its lens, keys and blur on the frames that are open.",
        ),
        Purpose(
            "save",
            "Save the picture",
            "Save",
            (),
            ".exr: scene-linear, with the lens in its header.   Others: as it looks here.",
            is_save=True,
            pictures=suffixes_written,
        ),
        Purpose(
            "camera",
            "Import the lens of a camera",
            "Import",
            (".usd", ".usda", ".usdc", ".usdz", ".json", ".csv"),
            "Focal length, f-stop, focus and film back, with keys for what moves.",
        ),
        Purpose(
            "grade",
            "Import a grade (ASC CDL)",
            "Import",
            GRADE_SUFFIXES,
            "Applied before the view, in pictures and movies; scene-linear EXR stay without it.",
        ),
        Purpose(
            "framing",
            "Import framing lines (ASC FDL)",
            "Import",
            (FDL_SUFFIX,),
            "Drawn with the guides, for pictures with the shape of one of its canvases.",
        ),
        Purpose(
            "opening",
            "Take a picture as the opening of the lens",
            "Take",
            (),
            "White lets light through, black blocks it.   Lamps behind the focus show it upright.",
            pictures=suffixes_read,
        ),
        Purpose(
            "sheet",
            "Write the pull sheet",
            "Write",
            (".html", ".pdf"),
            "Keys with picture, timecode, mark and distances; a table (.csv) is written beside it.",
            is_save=True,
        ),
        Purpose(
            "save reel",
            "Save the reel",
            "Save",
            (REEL_SUFFIX,),
            "The shots in their order. Shots with changes and no file are saved beside it.",
            is_save=True,
        ),
        Purpose("shot", "Open a shot", "Open", (SHOT_SUFFIX,), "A shot and its plate."),
        Purpose(
            "save shot",
            "Save the shot",
            "Save",
            (SHOT_SUFFIX,),
            "Lens, keys, marks and how the plate is read, as readable text.",
            is_save=True,
        ),
    )
}
