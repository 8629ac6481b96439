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
from heatlens.core.base.paths import unreadable
from heatlens.core.model.depth_words import DepthModelOutput
from heatlens.media.plate.estimate.trusted import check_trusted, key_of
from heatlens.media.plate.picture.display import srgb_encoded
from heatlens.media.plate.plate import FloatImage

_IMAGENET = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)  # mean and deviation of its pictures
_AS_IS = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
_EVEN = (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)
_SIDE_MOST = 4096  # largest side of an input whose size the network leaves open
_WHITE_PART = 0.98  # share of the pixels below the white that the network sees


@dataclass(frozen=True)
class NetworkFacts:
    """What a family of networks expects and gives.

    words       parts of the file name, any of which tells the family
    side_px     shorter side of the input, if the network leaves its size open
    multiple    that the sides must be multiples of
    mean, deviation  of the values that are subtracted and divided by, for sRGB values of 0 to 1
    white       of the input: 1, or 255 for networks that take bytes
    output      what comes out
    """

    words: tuple[str, ...]
    side_px: int
    multiple: int
    scale: tuple[tuple[float, ...], tuple[float, ...]]
    output: DepthModelOutput
    white: float = 1.0


# Sources: the preprocessing in the repositories of each family. The first that fits is taken.
_KNOWN = (
    NetworkFacts(("metric3d",), 616, 28, _IMAGENET, DepthModelOutput.METRES, 255.0),
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
_SIDE_GIVEN_MOST = 8192  # of a map of depth; networks of today give at most 2048
_UNKNOWN = NetworkFacts((), 0, 32, _AS_IS, DepthModelOutput.DISPARITY)


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

    def seen(self, color: FloatImage) -> FloatImage:
        """Return what the network gets, (1, 3, h, w), of light (H, W, 3)."""
        height, width = self.size or _open_size(color.shape, self.facts)
        planes = [resized(plane, width, height) for plane in np.moveaxis(as_display(color), 2, 0)]
        mean, deviation = (np.array(it, np.float32)[:, None, None] for it in self.facts.scale)
        values = (np.stack(planes) - mean) / deviation * np.float32(self.facts.white)
        return np.ascontiguousarray(values[None], np.float32)

    def estimate(self, seen: FloatImage) -> FloatImage:
        """Return the raw values (h, w) of the network. Raises InputError if it fails."""
        try:
            (output, *_) = self.run(None, {self.input_name: seen})
        except Exception as error:  # the runtime raises errors of its own for each kind of failure
            raise InputError(f"{self.path} failed on a picture: {one_line(error)}") from error
        if max(np.shape(output), default=0) > _SIDE_GIVEN_MOST:
            raise InputError(
                f"{self.path} gives values of shape {np.shape(output)}: sides are at most "
                f"{_SIDE_GIVEN_MOST} px."
            )
        values = np.asarray(output, np.float32).squeeze()
        if values.ndim != 2 or not np.isfinite(values).all():
            raise InputError(
                f"{self.path} gives no map of depth, but values of shape {np.shape(output)}."
            )
        return values


def network_at(path: str, output: DepthModelOutput) -> Network:
    """Return the network of a file. Raises InputError if it cannot be loaded."""
    file = Path(os.path.expanduser(path))
    try:
        status = file.stat()
        key = _key(file, status.st_mtime_ns)
    except OSError as error:
        raise unreadable(file, error) from error
    check_trusted(file, key)
    return _network(file, key, output)


@lru_cache(maxsize=4)  # large networks take a second to read
def _key(path: Path, _time_ns: int) -> str:
    return key_of(path)


@lru_cache(maxsize=2)
def _network(path: Path, key: str, output: DepthModelOutput) -> Network:
    session = _session(path)
    (needed, *others) = session.get_inputs()
    if others or not _takes_picture(needed.shape):
        raise InputError(
            f"{path} takes {[it.shape for it in session.get_inputs()]}; a network for depth takes "
            "one picture of 3 channels, (1, 3, height, width)."
        )
    facts, note = _facts_of(path, output)
    height, width = needed.shape[2:]
    size = (height, width) if isinstance(height, int) and isinstance(width, int) else None
    shapes = [it.shape for it in session.get_outputs()[:1]]
    if any(_is_impossible(shape) for shape in (needed.shape, *shapes)):
        raise InputError(
            f"{path} takes {needed.shape} and gives {shapes}: sides are 1 to {_SIDE_GIVEN_MOST} px."
        )
    return Network(path, facts, note, size, key, session.run, needed.name)


def _session(path: Path) -> Any:
    """Return the network, ready to run. Raises InputError if it cannot be loaded."""
    runtime = import_extra("onnxruntime")
    options = runtime.SessionOptions()
    options.log_severity_level = 4
    try:
        return runtime.InferenceSession(
            str(path), options, providers=runtime.get_available_providers()
        )
    except Exception as error:  # the runtime raises errors of its own for each kind of failure
        raise InputError(f"{path} is not a network that can be run: {one_line(error)}") from error


def _is_impossible(shape: list[object]) -> bool:
    """Return whether a size that the file states cannot be that of a picture."""
    return any(isinstance(side, int) and not 0 < side <= _SIDE_GIVEN_MOST for side in shape)


def _takes_picture(shape: list[object]) -> bool:
    """Return whether an input is (1, 3, height, width); sizes left open have names, or none."""
    return len(shape) == 4 and (shape[1] in (3, None) or isinstance(shape[1], str))


def _facts_of(path: Path, output: DepthModelOutput) -> tuple[NetworkFacts, str]:
    name = path.stem.lower().replace("-", "_").replace(" ", "_")
    known = next((one for one in _KNOWN if any(word in name for word in one.words)), None)
    facts, note = known or _UNKNOWN, ""
    if known is None:
        given = output is not DepthModelOutput.AUTO
        taken = f"gives {output if given else facts.output}"
        note = f"{path.name} is unknown: it gets sRGB values of 0 to 1, and {taken}."
    if output is not DepthModelOutput.AUTO:
        facts = replace(facts, output=output)
    return facts, note


def _open_size(shape: tuple[int, ...], facts: NetworkFacts) -> tuple[int, int]:
    """Return height and width of the input for a network that takes any size."""
    scale = facts.side_px / min(shape[:2]) if facts.side_px else 1.0
    step = facts.multiple
    return tuple(  # type: ignore[return-value]
        min(max(round(side * scale / step), 1) * step, _SIDE_MOST) for side in shape[:2]
    )


def as_display(color: FloatImage) -> FloatImage:
    """Return light as sRGB values of 0 to 1; what is brighter than white is scaled to it."""
    light = np.nan_to_num(color[:, :, :3], posinf=1e4, neginf=0.0)
    white = max(1.0, float(np.quantile(light.max(axis=2)[::4, ::4], _WHITE_PART)))
    return srgb_encoded(np.clip(light / white, 0.0, 1.0))


def resized(plane: FloatImage, width: int, height: int) -> FloatImage:
    """Return a plane (H, W) in another size, without ringing at edges."""
    if plane.shape == (height, width):
        return plane
    image = Image.fromarray(np.ascontiguousarray(plane, np.float32))
    return np.asarray(image.resize((width, height), Image.Resampling.BILINEAR), np.float32)
