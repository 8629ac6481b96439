"""Choose the picture, and the image with its depth, among the images that a renderer has sent.

Renderers send color and depth in one image, or as two images of one size. Some name the depth by
the channel (`Z`), others by the image (`depth`, with any single channel or the same gray thrice).
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
from heatlens.media.plate.windows import make_header_window

# A stream has no header that names the program, and only Mitsuba calls a channel T.
_MITSUBA_HEADER = {"software": "Mitsuba"}
_RAY_DEPTH_CHANNEL = re.compile(r"(^|\.)T$")
_NAME_LETTERS = 100  # longest path of a plate: file systems allow 255 bytes


def plate_path(name: str) -> Path:
    """Return a path for the image `name`, at which there is no file.

    A client chooses the name, so the path must not lead out of a folder.
    """
    safe_name = "".join(
        letter if letter.isprintable() and letter not in '/\\:*?"<>|' else "_" for letter in name
    )
    return Path(safe_name[-_NAME_LETTERS:].strip(". ") or "tev")


@dataclass(frozen=True)
class ChosenImage:
    """An image with the channels that a plate needs, copied from those that were sent.

    image         holds only the channels of color, alpha and depth
    aovs          all channels of the image as it was sent, and of the one with its depth
    skipped_note  a sentence on why a newer image is not the picture; "" if there is none
    """

    image: TevImage
    aovs: tuple[str, ...]
    skipped_note: str = ""


def choose_image(images: Sequence[TevImage], options: PlateOptions) -> ChosenImage:
    """Return the first of `images` that has color and depth, with only the channels it needs.

    `images` are sorted from new to old. Raises InputError about the first one if none has both.
    """
    problems: dict[str, InputError] = {}
    for image in images:
        depth = _find_depth_image(image, images, options)
        complete_image = image if depth is None else _add_depth_plane(image, depth)
        try:
            channels = copy_needed_channels(complete_image, options)
        except InputError as error:
            problems[image.name] = error
            continue
        if depth is not None:
            problems.pop(depth.image.name, None)
        skipped_note = next(map(str, problems.values()), "")
        return ChosenImage(channels, tuple(complete_image.planes), skipped_note)
    raise next(
        iter(problems.values()),
        InputError("No image has arrived from a renderer yet: send one to this address."),
    )


def copy_needed_channels(image: TevImage, options: PlateOptions) -> TevImage:
    """Copy `image` with only the channels that a plate needs.

    If `options` name a file for the depth, no depth channel is needed. Raises InputError if it has
    no color or no depth.
    """
    path, headers = plate_path(image.name), [header_of(image)]
    color = choose_color(path, headers, options.color_layer)
    needed_keys = {ref.key for ref in (*color.rgb, color.alpha) if ref is not None}
    if options.depth_source is None:
        is_coc = options.depth_convention.facts.is_coc
        needed_keys.add(choose_depth(path, headers, options.depth_channel, color, is_coc).key)
    return replace(
        image,
        planes={key: plane.copy() for key, plane in image.planes.items() if key in needed_keys},
    )


def header_of(image: TevImage) -> Header:
    """Return the header that an EXR file with the channels of `image` would have."""
    window = make_header_window(Box(0, 0, image.width, image.height))
    header: dict[str, object] = {
        "channels": [
            SimpleNamespace(name=channel, xSampling=1, ySampling=1) for channel in image.planes
        ],
        "dataWindow": window,
        "displayWindow": window,
    }
    return header | (_MITSUBA_HEADER if any(map(_RAY_DEPTH_CHANNEL.search, image.planes)) else {})


@dataclass(frozen=True)
class _DepthImage:
    """A depth sent as another image than the color.

    image  the image that holds the depth
    key    the depth's channel in that image
    name   the name of that channel when it is added to the image of the color
    """

    image: TevImage
    key: str
    name: str


def _add_depth_plane(image: TevImage, depth: _DepthImage) -> TevImage:
    """Return `image` with the depth channel of another image added."""
    return replace(image, planes={**image.planes, depth.name: depth.image.planes[depth.key]})


def _find_depth_image(
    image: TevImage, images: Sequence[TevImage], options: PlateOptions
) -> _DepthImage | None:
    """Return the depth in another image of the same size, or None if `image` has its own."""
    is_coc, name = options.depth_convention.facts.is_coc, options.depth_channel
    if options.depth_source is not None or _find_own_depth(image, name, is_coc) is not None:
        return None
    size = image.width, image.height
    for candidate in images:
        if candidate is not image and (candidate.width, candidate.height) == size:
            depth = _as_depth_image(candidate, name, is_coc)
            if depth is not None:
                return depth
    return None


def _as_depth_image(image: TevImage, name: str | None, is_coc: bool) -> _DepthImage | None:
    """Return the depth channel of an image sent as a depth; None for other images."""
    if name is not None and (image.name == name or name.startswith(f"{image.name}.")):
        keys = {f"{image.name}.{key}": key for key in image.planes}
        return _DepthImage(image, keys.get(name, next(iter(image.planes))), name)
    ref = _find_own_depth(image, name, is_coc)
    word = next(filter(DEPTH_WORDS.__contains__, _words(image.name)), "")
    if ref is not None:
        if not word and _has_color(image):
            return None  # a complete picture of its own, whose depth may be of another moment
        return _DepthImage(image, ref.key, f"{word or 'depth'}.{ref.leaf}")
    return _depth_by_image_name(image, word) if name is None and word else None


def _depth_by_image_name(image: TevImage, word: str) -> _DepthImage | None:
    """Return the red or only channel of an image whose name has a word for depth, or None."""
    by_letter = {key.lower(): key for key in reversed(image.planes)}
    if {"r", "g", "b"} <= by_letter.keys():
        return _DepthImage(image, key=by_letter["r"], name=f"{word}.R")
    if len(image.planes) == 1:
        return _DepthImage(image, key=next(iter(image.planes)), name=f"{word}.V")
    return None


def _find_own_depth(image: TevImage, name: str | None, is_coc: bool) -> ChannelRef | None:
    """Return the depth channel of an image; None if it has none."""
    try:
        return choose_depth(
            plate_path(image.name), [header_of(image)], name, color=None, prefers_coc=is_coc
        )
    except InputError:
        return None


def _has_color(image: TevImage) -> bool:
    """Return whether an image has channels from which a color can be chosen."""
    try:
        choose_color(plate_path(image.name), [header_of(image)], layer=None)
    except InputError:
        return False
    return True


def _words(name: str) -> list[str]:
    """Return the words of an image's name, and all of them joined, in lower case."""
    stem = re.sub(r"\.(exr|pfm|hdr)$", "", name.lower())
    words = re.split(r"[^a-z]+", stem)
    return ["".join(words), *words]
