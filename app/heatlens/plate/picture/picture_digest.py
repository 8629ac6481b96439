"""Digests that identify a rendered picture, for exports and for playback in the window."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace

from heatlens.model.lens.lens import Lens

_DIGEST_BYTES = 16


def digest(facts: Mapping[str, object]) -> str:
    """Return 32 hexadecimal digits that are equal for equal facts; facts must fit into JSON."""
    text = json.dumps(facts, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=_DIGEST_BYTES).hexdigest()


def without_advice(lens: Lens) -> Lens:
    """Return the lens without the values that only warn or measure and change no pixel.

    An aperture image is identified by the digest of its light, not by the path of its file.
    """
    image = lens.aperture_image
    named = None if image is None else replace(image, path=image.digest)
    return replace(lens, acceptable_coc_mm=None, close_focus_m=None, aperture_image=named)
