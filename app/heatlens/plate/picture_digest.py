"""Digests by which a rendered picture is known again, in an export as in the window's playback."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from heatlens.model.lens import Lens

_DIGEST_BYTES = 16


def digest(facts: Mapping[str, Any]) -> str:
    """Return 32 hexadecimal digits, the same for the same facts; facts are what JSON has."""
    text = json.dumps(facts, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=_DIGEST_BYTES).hexdigest()


def without_advice(lens: Lens) -> Lens:
    """Return the lens without the values that warn and measure, but leave every pixel as it is.

    An aperture image is known by the digest of its light, and not by the path of its file.
    """
    image = lens.aperture_image
    named = None if image is None else replace(image, path=image.digest)
    return replace(lens, acceptable_coc_mm=None, close_focus_m=None, aperture_image=named)
