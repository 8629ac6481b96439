"""From the images that a renderer has sent, choose the picture and the one with its depth.

Renderers send colour and depth in one image, or as two images of one size. Some name the depth by
the channel (`Z`), others by the image (`depth`, with any single channel or the same grey thrice).
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.live.stream.images import TevImage
from heatlens.media.plate.header.channel_choice import DEPTH_WORDS, choose_color, choose_depth
from heatlens.media.plate.header.channels import ChannelRef, Header
from heatlens.media.plate.windows import header_at_box

# A stream has no header that names the program, and only Mitsuba calls a channel T.
_OF_MITSUBA = {"software": "Mitsuba"}
_ALONG_RAY = re.compile(r"(^|\.)T$")
_NAME_LETTERS = 100  # longest path of a plate: file systems allow 255 bytes


def plate_path(name: str) -> Path:
    """Return a path for the image `name`, at which there is no file.

    A client chooses the name, so the path must not lead out of a folder.
    """
    plain = "".join(c if c.isprintable() and c not in '/\\:*?"<>|' else "_" for c in name)
    return Path(plain[-_NAME_LETTERS:].strip(". ") or "tev")


@dataclass(frozen=True)
class ChosenImage:
    """A copy of the channels of an image that a plate needs.

    image        holds only the channels of colour, alpha and depth
    aovs         all channels of the image as it was sent, and of the one with its depth
    passed_over  a sentence on why a newer image is not the picture; "" if there is none
    """

    image: TevImage
    aovs: tuple[str, ...]
    passed_over: str = ""


def chosen_image(images: Sequence[TevImage], options: PlateOptions) -> ChosenImage:
    """Return the first of `images`, sorted from new to old, that has colour and depth.

    Raises InputError about the first one if none has both.
    """
    why_not: dict[str, InputError] = {}
    for image in images:
        depth = _depth_beside(image, images, options)
        whole = image if depth is None else _joined(image, depth)
        try:
            channels = chosen_channels(whole, options)
        except InputError as error:
            why_not[image.name] = error
            continue
        if depth is not None:
            why_not.pop(depth.image.name, None)
        passed_over = next(map(str, why_not.values()), "")
        return ChosenImage(channels, tuple(whole.planes), passed_over)
    raise next(iter(why_not.values()), InputError("No image has arrived yet."))


def chosen_channels(image: TevImage, options: PlateOptions) -> TevImage:
    """Copy `image` with only the channels that a plate needs.

    If `options` name a file for the depth, no depth channel is needed. Raises InputError if it has
    no colour or no depth.
    """
    path, headers = plate_path(image.name), [header_of(image)]
    color = choose_color(path, headers, options.color_layer)
    wanted = {ref.key for ref in (*color.rgb, color.alpha) if ref is not None}
    if options.depth_source is None:
        is_coc = options.depth_convention.facts.is_coc
        wanted.add(choose_depth(path, headers, options.depth_channel, color, is_coc).key)
    return replace(image, planes={k: p.copy() for k, p in image.planes.items() if k in wanted})


def header_of(image: TevImage) -> Header:
    """Return the header that an EXR file with the channels of `image` would have."""
    window = header_at_box(Box(0, 0, image.width, image.height))
    header: dict[str, object] = {
        "channels": [SimpleNamespace(name=c, xSampling=1, ySampling=1) for c in image.planes],
        "dataWindow": window,
        "displayWindow": window,
    }
    return header | (_OF_MITSUBA if any(map(_ALONG_RAY.search, image.planes)) else {})


@dataclass(frozen=True)
class _DepthBeside:
    """The depth in another image, and the name of its channel among those of the colour."""

    image: TevImage
    key: str
    name: str


def _joined(image: TevImage, depth: _DepthBeside) -> TevImage:
    """Return `image` with the depth channel of another image added."""
    return replace(image, planes={**image.planes, depth.name: depth.image.planes[depth.key]})


def _depth_beside(
    image: TevImage, images: Sequence[TevImage], options: PlateOptions
) -> _DepthBeside | None:
    """Return the depth in another image of the same size, or None if `image` has its own."""
    is_coc, name = options.depth_convention.facts.is_coc, options.depth_channel
    if options.depth_source is not None or _own_depth(image, name, is_coc) is not None:
        return None
    size = image.width, image.height
    for other in images:
        if other is not image and (other.width, other.height) == size:
            depth = _depth_of(other, name, is_coc)
            if depth is not None:
                return depth
    return None


def _depth_of(image: TevImage, name: str | None, is_coc: bool) -> _DepthBeside | None:
    """Return the depth channel of an image sent as a depth; None for other images."""
    if name is not None and (image.name == name or name.startswith(f"{image.name}.")):
        keys = {f"{image.name}.{key}": key for key in image.planes}
        return _DepthBeside(image, keys.get(name, next(iter(image.planes))), name)
    ref = _own_depth(image, name, is_coc)
    word = next(filter(DEPTH_WORDS.__contains__, _words(image.name)), "")
    if ref is not None:
        if not word and _has_color(image):
            return None  # a complete picture of its own, whose depth may be of another moment
        return _DepthBeside(image, ref.key, f"{word or 'depth'}.{ref.leaf}")
    return _called_depth(image, word) if name is None and word else None


def _called_depth(image: TevImage, word: str) -> _DepthBeside | None:
    """Return the red or only channel of an image whose name contains a word for depth."""
    by_letter = {key.lower(): key for key in reversed(image.planes)}
    if {"r", "g", "b"} <= by_letter.keys():
        return _DepthBeside(image, by_letter["r"], f"{word}.R")
    if len(image.planes) == 1:
        return _DepthBeside(image, next(iter(image.planes)), f"{word}.V")
    return None


def _own_depth(image: TevImage, name: str | None, is_coc: bool) -> ChannelRef | None:
    try:
        return choose_depth(plate_path(image.name), [header_of(image)], name, None, is_coc)
    except InputError:
        return None


def _has_color(image: TevImage) -> bool:
    try:
        choose_color(plate_path(image.name), [header_of(image)], None)
    except InputError:
        return False
    return True


def _words(name: str) -> list[str]:
    """Return the words of an image's name, and all of them joined, in lower case."""
    stem = re.sub(r"\.(exr|pfm|hdr)$", "", name.lower())
    words = re.split(r"[^a-z]+", stem)
    return ["".join(words), *words]
