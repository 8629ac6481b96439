"""Run a network that estimates depth from a picture: an ONNX file of the user's own.

No network comes with heatlens, and none is fetched.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import unreadable_error
from heatlens.core.model.depth_words import DepthModelOutput
from heatlens.media.plate.estimate.trusted import check_trusted, content_key
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.plate import FloatImage

# Mean and deviation for each color: of the pictures of ImageNet, and two that are the same for all.
_IMAGENET = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
_AS_IS = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)  # leaves 0 to 1 unchanged
_EVEN = (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)  # maps 0 to 1 to -1 to 1
_SIDE_MOST = 4096  # largest side of an input whose size the network leaves open
_WHITE_PART = 0.98  # share of the pixels that are at most as bright as the network's white


@dataclass(frozen=True)
class NetworkFacts:
    """The input that a family of networks expects, and its output.

    words       parts of file names, any of which identifies the family
    side_px     shorter side of the input, if the network leaves its size open
    multiple    number of pixels of which the sides must be multiples
    scale       mean, which is subtracted from sRGB values of 0 to 1, and deviation, the divisor
    output      quantity that the network estimates
    white       value of white in the input: 1, or 255 for networks that take bytes
    """

    words: tuple[str, ...]
    side_px: int
    multiple: int
    scale: tuple[tuple[float, ...], tuple[float, ...]]
    output: DepthModelOutput
    white: float = 1.0


# Sources: the preprocessing in the repositories of each family. The first that fits is taken.
_KNOWN_FAMILIES = (
    NetworkFacts(
        words=("metric3d",),
        side_px=616,
        multiple=28,
        scale=_IMAGENET,
        output=DepthModelOutput.METRES,
        white=255.0,
    ),
    NetworkFacts(("depth_pro", "depthpro"), 1536, 1536, _EVEN, DepthModelOutput.METRES),
    NetworkFacts(("zoedepth", "zoe_depth"), 384, 32, _EVEN, DepthModelOutput.METRES),
    NetworkFacts(("metric", "da3metric"), 518, 14, _IMAGENET, DepthModelOutput.METRES),
    NetworkFacts(("depth_anything", "da3"), 518, 14, _IMAGENET, DepthModelOutput.DISPARITY),
    NetworkFacts(
        ("midas_small", "midas_v21_small"), 256, 32, _IMAGENET, DepthModelOutput.DISPARITY
    ),
    NetworkFacts(("midas", "dpt"), 384, 32, _EVEN, DepthModelOutput.DISPARITY),
    NetworkFacts(("tcmonodepth", "tc_mono"), 384, 32, _IMAGENET, DepthModelOutput.DISPARITY),
)
_MAP_SIDE_MOST = 8192  # largest side of a map of depth; networks of today give at most 2048
_UNKNOWN_FAMILY = NetworkFacts((), 0, 32, _AS_IS, DepthModelOutput.DISPARITY)


@dataclass(frozen=True, eq=False)
class Network:
    """A loaded network; `note` is a sentence on what was assumed of it, or ""."""

    path: Path
    facts: NetworkFacts
    note: str
    size: tuple[int, int] | None  # fixed height and width of the input
    key: str  # changes with the file
    run: Callable[..., list[FloatImage]]
    input_name: str

    def prepare_input(self, color: FloatImage) -> FloatImage:
        """Return light (H, W, 3) as the input of the network: display values (1, 3, h, w)."""
        height, width = self.size or _choose_input_size(color.shape, self.facts)
        planes = [
            resize_plane(plane, width, height)
            for plane in np.moveaxis(convert_to_display(color), 2, 0)
        ]
        mean, deviation = (np.array(it, np.float32)[:, None, None] for it in self.facts.scale)
        values = (np.stack(planes) - mean) / deviation * np.float32(self.facts.white)
        return np.ascontiguousarray(values[None], np.float32)

    def estimate(self, network_input: FloatImage) -> FloatImage:
        """Return the raw values (h, w) of the network. Raises InputError if it fails."""
        try:
            (output, *_) = self.run(None, {self.input_name: network_input})
        except Exception as error:  # the runtime raises errors of its own for each kind of failure
            raise InputError(f"{self.path} failed on a picture: {one_line(error)}") from error
        if max(np.shape(output), default=0) > _MAP_SIDE_MOST:
            raise InputError(
                f"{self.path} gives a depth of shape {np.shape(output)}: heatlens takes at most "
                f"{_MAP_SIDE_MOST} px a side. Choose another network."
            )
        values = np.asarray(output, np.float32).squeeze()
        if values.ndim != 2 or not np.isfinite(values).all():
            raise InputError(
                f"{self.path} gives no map of depth, but values of shape {np.shape(output)}."
            )
        return values


def network_at(path: str, output: DepthModelOutput) -> Network:
    """Return the network in the file at `path`.

    `output` is the quantity that it estimates; AUTO lets the name of the file decide. Raises
    InputError if the network cannot be loaded, or if the user did not agree to run it.
    """
    file = Path(os.path.expanduser(path))
    try:
        status = file.stat()
        key = _cached_key(file, status.st_mtime_ns)
    except OSError as error:
        raise unreadable_error(file, error) from error
    check_trusted(file, key)
    return _load_network(file, key, output)


@lru_cache(maxsize=4)  # large networks take a second to read
def _cached_key(path: Path, _time_ns: int) -> str:
    """Return the key of a file's content; another `_time_ns` makes it compute the key again."""
    return content_key(path)


@lru_cache(maxsize=2)
def _load_network(path: Path, key: str, output: DepthModelOutput) -> Network:
    """Load a network and check its input and output. Raises InputError if they do not fit."""
    session = _open_session(path)
    (picture_input, *other_inputs) = session.get_inputs()
    if other_inputs or not _takes_picture(picture_input.shape):
        raise InputError(
            f"{path} takes {[it.shape for it in session.get_inputs()]}; a network for depth takes "
            "one picture of 3 channels, (1, 3, height, width)."
        )
    facts, note = _facts_by_file_name(path, output)
    height, width = picture_input.shape[2:]
    size = (height, width) if isinstance(height, int) and isinstance(width, int) else None
    output_shapes = [it.shape for it in session.get_outputs()[:1]]
    if any(_is_impossible_shape(shape) for shape in (picture_input.shape, *output_shapes)):
        raise InputError(
            f"{path} takes {picture_input.shape} and gives {output_shapes}: heatlens runs "
            f"networks with sides of 1 to {_MAP_SIDE_MOST} px. Choose another."
        )
    return Network(
        path=path,
        facts=facts,
        note=note,
        size=size,
        key=key,
        run=session.run,
        input_name=picture_input.name,
    )


def _open_session(path: Path) -> Any:
    """Return the network, ready to run. Raises InputError if it cannot be loaded."""
    runtime = import_extra("onnxruntime")
    options = runtime.SessionOptions()
    options.log_severity_level = 4
    try:
        return runtime.InferenceSession(
            str(path), options, providers=runtime.get_available_providers()
        )
    except Exception as error:  # the runtime raises errors of its own for each kind of failure
        raise InputError(
            f"{path} is not a network that can be run ({one_line(error)}). Export it as ONNX again."
        ) from error


def _is_impossible_shape(shape: list[object]) -> bool:
    """Return whether a size that the file states cannot be that of a picture."""
    return any(isinstance(side, int) and not 0 < side <= _MAP_SIDE_MOST for side in shape)


def _takes_picture(shape: list[object]) -> bool:
    """Return whether an input is (1, 3, height, width); sizes left open have names, or none."""
    return len(shape) == 4 and (shape[1] in (3, None) or isinstance(shape[1], str))


def _facts_by_file_name(path: Path, output: DepthModelOutput) -> tuple[NetworkFacts, str]:
    """Return the facts of the family in the file's name, and a note if the family is unknown."""
    name = path.stem.lower().replace("-", "_").replace(" ", "_")
    known_facts = next(
        (one for one in _KNOWN_FAMILIES if any(word in name for word in one.words)), None
    )
    facts, note = known_facts or _UNKNOWN_FAMILY, ""
    if known_facts is None:
        is_output_given = output is not DepthModelOutput.AUTO
        output_words = f"gives {output if is_output_given else facts.output}"
        note = f"{path.name} is unknown: it gets sRGB values of 0 to 1, and {output_words}."
    if output is not DepthModelOutput.AUTO:
        facts = replace(facts, output=output)
    return facts, note


def _choose_input_size(shape: tuple[int, ...], facts: NetworkFacts) -> tuple[int, int]:
    """Return height and width of the input for a network that takes any size."""
    scale = facts.side_px / min(shape[:2]) if facts.side_px else 1.0
    step = facts.multiple
    return tuple(  # type: ignore[return-value]
        min(max(round(side * scale / step), 1) * step, _SIDE_MOST) for side in shape[:2]
    )


def convert_to_display(color: FloatImage) -> FloatImage:
    """Return light as sRGB values of 0 to 1, scaled so that bright pixels do not exceed white."""
    light = np.nan_to_num(color[:, :, :3], posinf=1e4, neginf=0.0)
    white = max(1.0, float(np.quantile(light.max(axis=2)[::4, ::4], _WHITE_PART)))
    return encode_srgb(np.clip(light / white, 0.0, 1.0))


def resize_plane(plane: FloatImage, width: int, height: int) -> FloatImage:
    """Return a plane (H, W) in another size, without ringing at edges."""
    if plane.shape == (height, width):
        return plane
    image = Image.fromarray(np.ascontiguousarray(plane, np.float32))
    return np.asarray(image.resize((width, height), Image.Resampling.BILINEAR), np.float32)
