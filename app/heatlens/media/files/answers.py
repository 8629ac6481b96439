"""Pack and unpack the answers of reading processes, so that an answer cannot run any code.

An answer is a pickle, because it holds arrays and values of many classes. A pickle can name any
function of any module and have it called. Unpacking therefore accepts only the names below.
`tests/media/files/test_answers.py` finds a class of an answer that is missing here.
"""

import io
import pickle
from collections.abc import Mapping

# Arrays as NumPy packs them, by version 1 and by version 2.
_ARRAYS = {
    "numpy": ("dtype", "ndarray"),
    "numpy.core.multiarray": ("_reconstruct", "scalar"),
    "numpy._core.multiarray": ("_reconstruct", "scalar"),
    "numpy.core.numeric": ("_frombuffer",),
    "numpy._core.numeric": ("_frombuffer",),
}
_VALUES = {
    "PIL.TiffImagePlugin": ("IFDRational",),  # in the EXIF of a photograph
    "collections": ("OrderedDict",),
    "fractions": ("Fraction",),
    "pathlib": ("Path", "PosixPath", "PurePosixPath", "WindowsPath", "PureWindowsPath"),
}
_HEATLENS_CLASSES = {
    "heatlens.core.base.errors": (
        "FaultError",
        "GpuError",
        "HeatlensError",
        "InputError",
        "MissingPackageError",
    ),
    "heatlens.media.camera.samples": ("CameraSamples",),
    "heatlens.media.files.json_record": ("JsonEntry",),
    "heatlens.core.model.curves.frames": ("FrameRange",),
    "heatlens.core.model.lens.lens": ("LensModel",),
    "heatlens.core.model.lens.opening_image": ("OpeningImage",),
    "heatlens.core.model.shot.camera_track": ("CameraTrack", "Pose", "PoseKey"),
    "heatlens.core.model.shot.framing": ("SceneTiming", "WorldAxis"),
    "heatlens.core.model.shot.grade": ("Grade",),
    "heatlens.core.model.shot.reel": ("Reel", "ReelShot", "Retime"),
    "heatlens.core.model.timecode": ("Timecode",),
    "heatlens.core.model.view.guides": ("Canvas", "FrameLine"),
    "heatlens.media.plate.picture.picture_open": ("RawPicture",),
    "heatlens.media.scene.gltf.animation": ("Animation",),
    "heatlens.media.scene.gltf.deform": ("Binding", "DeformedMesh", "Skin", "Targets"),
    "heatlens.media.scene.gltf.json_values": ("Record",),
    "heatlens.media.scene.gltf.lights": ("MovingLights",),
    "heatlens.media.scene.gltf.nodes": ("NodeTree",),
    "heatlens.media.scene.gltf.read": ("_NodeMotion",),
    "heatlens.media.scene.gltf.value_track": ("ValueTrack",),
    "heatlens.media.scene.material": ("MapPlace", "Material", "Wrap"),
    "heatlens.media.scene.scene": (
        *("Daylight", "Instance", "Lighting", "Mesh", "PointLight", "Scene", "SceneCamera"),
    ),
    "heatlens.media.scene.usd.read": ("_SampledMotion",),
}
ALLOWED: Mapping[str, tuple[str, ...]] = _ARRAYS | _VALUES | _HEATLENS_CLASSES


class AnswerError(Exception):
    """An answer is damaged, or names a class or function that is not allowed."""


class _Unpacker(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> object:
        """Return a class or function of the list; raise AnswerError for any other."""
        if name not in ALLOWED.get(module, ()):
            raise AnswerError(f"the answer of a reading process names {module}.{name}")
        return super().find_class(module, name)


def pack_answer(answer: object) -> bytes:
    """Return `answer` as bytes, for `unpack_answer`."""
    return pickle.dumps(answer, protocol=pickle.HIGHEST_PROTOCOL)


def unpack_answer(answer: bytes) -> object:
    """Return the answer that `pack_answer` packed.

    Raises AnswerError for bytes that name anything outside the list, or are no answer at all.
    """
    try:
        return _Unpacker(io.BytesIO(answer)).load()
    except (pickle.UnpicklingError, EOFError, ValueError, LookupError, AttributeError) as error:
        raise AnswerError(f"the answer of a reading process is damaged ({error})") from error
