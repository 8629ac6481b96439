"""Tell which looks and which method a view compares, and find them in a shot."""

from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import GRID_MOST, Against, Compare, ViewState

CURRENT_LENS = ""  # in place of a look's name: the current lens


def is_look_b(view: ViewState) -> bool:
    """Return True if B is visible and shows a look."""
    return _shows_as_b(view, Against.LOOK)


def is_shot_b(view: ViewState) -> bool:
    """Return True if B is visible and shows another shot."""
    return _shows_as_b(view, Against.SHOT)


def _shows_as_b(view: ViewState, against: Against) -> bool:
    return view.compare not in (Compare.OFF, Compare.GRID) and view.against is against


def method_of_b(view: ViewState, has_many_views: bool) -> Method | None:
    """Return the method of B; None if B is not visible or needs a scene and none is open."""
    if not _shows_as_b(view, Against.METHOD):
        return None
    return view.b_method if has_many_views or not view.b_method.needs_scene else None


def look_named(shot: Shot, name: str) -> Look | None:
    """Return the look of this name; None if the shot has no such look."""
    return next((look for look in shot.looks if look.name == name), None)


def grid_names(view: ViewState, shot: Shot) -> tuple[str, ...]:
    """Return the names in the grid: up to four looks, and the current lens if fewer than four."""
    names = [look.name for look in shot.looks]
    grid = tuple(name for name in names if name in view.grid) or tuple(names)
    grid = grid[:GRID_MOST]
    return grid if len(grid) == GRID_MOST else (*grid, CURRENT_LENS)


def visible_looks(view: ViewState, shot: Shot) -> tuple[Look, ...]:
    """Return the visible looks: those of the grid, or the compared ones."""
    names: tuple[str, ...] = ()
    if view.compare is Compare.GRID:
        names = grid_names(view, shot)
    elif is_look_b(view):
        names = tuple({view.a_look: None, view.b_look: None})
    looks = (look_named(shot, name) for name in names)
    return tuple(look for look in looks if look is not None)
