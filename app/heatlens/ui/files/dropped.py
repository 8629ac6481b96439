"""Files that are dropped on the window: one, or a picture together with its depth."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from heatlens.sequence.depth_files import picture_and_depth

if TYPE_CHECKING:
    from heatlens.ui.app import App


def open_dropped(app: "App", names: Sequence[str]) -> None:
    """Open a picture and its depth, where these are the two by their names; else the first."""
    pair = picture_and_depth(names)
    if pair is None:
        app.open(names[0])
        return
    picture, depth = pair
    app.open(picture, replace(app.filing.options_for(picture), depth_source=depth))
