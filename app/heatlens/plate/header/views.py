"""Find the views of a stereo picture, and the view that each channel belongs to.

A part with a single view names it in the attribute `view`. A part with several lists them in
`multiView`; the view then stands before the last component of a channel's name, and channels
without a layer belong to the first view. Some programs only write left and right into the names.
Source: the OpenEXR documents "Storing Multi-View Images in OpenEXR Files" and "Standard
Attributes".
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any

_EYES = ("left", "right")
_SEPARATORS = re.compile(r"[-._ ]")


def views_of(headers: Sequence[Mapping[str, object]]) -> tuple[str, ...]:
    """Return the views that the headers name, the default view first; () for fewer than two."""
    listed = [name for header in headers for name in _listed_views(header)]
    own = [str(header["view"]) for header in headers if header.get("view")]
    found = list(dict.fromkeys(listed or own))
    if not found:
        found = _eyes_in_names(headers)
    if not listed:  # the order of the parts means nothing
        found.sort(key=lambda name: name.lower() != _EYES[0])
    return tuple(found) if len(found) > 1 else ()


def view_of(header: Mapping[str, object], full_name: str, views: Sequence[str]) -> str:
    """Return the view of a channel; "" if it belongs to all views or there are none."""
    own = str(header.get("view", ""))
    listed = _listed_views(header)
    if own in views and len(listed) < 2:
        return own
    words = [word.lower() for word in _SEPARATORS.split(full_name)]
    named = next((view for view in views if view.lower() in words), "")
    if named or len(listed) < 2:
        return named
    return "" if "." in full_name else listed[0]


def without_view(name: str, view: str) -> str:
    """Remove the name of the view: `rgba_left` and `left.rgba` become `rgba`."""
    if not view:
        return name
    words = re.split(r"([-._ ])", name)
    kept = [i for i in range(0, len(words), 2) if words[i].lower() != view.lower()]
    return "".join(words[i] + (words[i + 1] if i != kept[-1] else "") for i in kept)


def _listed_views(header: Mapping[str, object]) -> list[str]:
    """Return the names in `multiView`, which an older writer may have stored as another type."""
    value = header.get("multiView")
    return [str(name) for name in value] if isinstance(value, list | tuple) else []


def _eyes_in_names(headers: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return left and right if the names of parts or channels contain both."""
    names = [str(header.get("name", "")) for header in headers]
    names += [channel.name for header in headers for channel in header.get("channels", ())]
    words = {word.lower() for name in names for word in _SEPARATORS.split(name)}
    return list(_EYES) if set(_EYES) <= words else []
