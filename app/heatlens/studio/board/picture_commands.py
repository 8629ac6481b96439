"""List the commands on the picture: what is shown of it, overlays, guides and comparison."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from heatlens.core.model.shot.settings import Method, barred_methods
from heatlens.core.model.view import overlays
from heatlens.core.model.view.guides import MATTES
from heatlens.core.model.view.view import Against, Compare
from heatlens.studio.board.command import Command, in_group, page_command, remote_command
from heatlens.studio.board.session import Session

_COMPARED = {
    Compare.WIPE: ("Wipe", "W"),
    Compare.FLIP: ("Show B", "X"),
    Compare.DIFFERENCE: ("Difference", "E"),
}
_GUIDE_LINES = {"thirds": "Thirds", "safe_areas": "Safe areas", "centre": "Centre cross"}


def picture_commands(session: Session) -> Iterator[Command]:
    """Yield the commands of the menus View and Compare."""
    yield from (*_view(session), *_overlays(session), *_guides(session), *_compare(session))


def _switch(
    session: Session, field: str, name: str, key: str = "", sheet: str | None = None
) -> Command:
    """Return the command that switches a field of the view."""
    return remote_command(
        *(name, partial(session.pictures.commands.toggle, field), key),
        is_on=lambda: bool(getattr(session.pictures.view.state, field)),
        sheet=sheet,
    )


def _view(session: Session) -> Iterator[Command]:
    """Yield commands for the View menu."""
    view, switch = session.pictures.commands, partial(_switch, session)
    ruler = view.ruler
    blur = switch("depth_of_field", "Depth of field", "D", "")
    yield from in_group("View", "blur", replace(blur, synonyms=("DoF", "bokeh", "blur")))
    yield from in_group(
        *("View", "zoom"),
        remote_command("Fit", view.fit, "F"),
        remote_command("1:1", view.one_to_one, "1"),
        remote_command("Zoom in", partial(view.zoom, 2.0), "+", repeats=True),
        remote_command("Zoom out", partial(view.zoom, 0.5), "-", repeats=True),
    )
    measured = remote_command(
        *("Ruler", view.toggle_ruler, "N"), is_on=lambda: ruler.is_on, barred=ruler.why_not
    )
    yield from in_group(
        *("View", "pixels"),
        switch("pixel_grid", "Pixel grid", "G"),
        switch("pixel_values", "Values in pixels", "Shift+G"),
        measured,
        switch("loupe", "Loupe", "Shift+D"),
    )
    graded = remote_command(
        *("Grade of the shot", partial(view.toggle, "is_graded")),
        is_on=lambda: session.pictures.view.state.is_graded,
        barred=lambda: "" if session.editing.shot.grade else "The shot has no grade (ASC CDL).",
    )
    yield from in_group(
        *("View", "exposure"),
        page_command("Brighter", partial(view.expose, 1), "Ctrl+Up", repeats=True),
        page_command("Darker", partial(view.expose, -1), "Ctrl+Down", repeats=True),
        remote_command("Reset exposure and gamma", view.reset_exposure_and_gamma, "Ctrl+0"),
    )
    yield from in_group("View", "grade", graded)
    unit = page_command("Metres or feet", view.toggle_unit, "U", sheet="Units")
    yield from in_group("View", "interface", unit)


def _overlays(session: Session) -> Iterator[Command]:
    """Yield the switches of focus peaking and of each overlay."""
    toggle = session.pictures.commands.toggle_overlay
    is_on: Callable[[str], bool] = lambda name: session.pictures.view.state.overlay == name  # noqa: E731
    yield from in_group(
        *("View", "overlays"),
        _switch(session, "is_peaking", "Focus peaking", "Shift+P", "Over the picture"),
        *(
            page_command(
                *(overlay.words, partial(toggle, overlay.name), overlay.key),
                is_on=partial(is_on, overlay.name),
                sheet="Over the picture",
            )
            for overlay in overlays.OVERLAYS
        ),
    )


def _guides(session: Session) -> Iterator[Command]:
    """Yield the switches of frame masks and guide lines."""
    view, seen = session.pictures.commands, session.pictures.view
    yield from in_group(
        *("View", "mattes"),
        *(
            replace(
                remote_command(
                    *(f"Frame mask {name}", partial(view.toggle_matte, aspect)),
                    is_on=partial(lambda aspect: seen.state.guides.aspect == aspect, aspect),
                    sheet="Guides",
                ),
                synonyms=("letterbox", "matte"),
            )
            for name, aspect in MATTES.items()
        ),
    )
    yield from in_group(
        *("View", "guides"),
        *(
            remote_command(
                *(name, partial(view.toggle_guide, field)),
                is_on=partial(lambda field: bool(getattr(seen.state.guides, field)), field),
                sheet="Guides",
            )
            for field, name in _GUIDE_LINES.items()
        ),
    )


def _compare(session: Session) -> Iterator[Command]:
    """Yield the commands that compare: side by side, gain, the reference, methods."""
    pictures = session.pictures
    view, seen = pictures.commands, pictures.view
    is_on: Callable[[Compare], bool] = lambda how: seen.state.compare is how  # noqa: E731
    yield from in_group(
        *("Compare", "with"),
        *(
            remote_command(name, partial(view.toggle_compare, how), key, is_on=partial(is_on, how))
            for how, (name, key) in _COMPARED.items()
        ),
        remote_command(
            *("Grid of looks", pictures.looks.toggle_grid, "Shift+W"),
            is_on=partial(is_on, Compare.GRID),
        ),
    )
    yield from in_group(
        *("Compare", "gain"),
        remote_command("More gain", partial(view.step_gain, 1), "."),
        remote_command("Less gain", partial(view.step_gain, -1), ","),
    )
    swap = remote_command(
        *("Compare with the reference", view.swap_b, "R"),
        is_on=lambda: seen.state.against is Against.REFERENCE,
    )
    yield from in_group("Compare", "b", swap)
    yield from in_group(
        *("Compare", "method"),
        *(
            remote_command(
                *(f"Compare with {method or 'pinhole'}", partial(view.compare_with, method)),
                barred=partial(
                    lambda it: barred_methods(pictures.renderer.has_many_views).get(str(it), ""),
                    method,
                ),
            )
            for method in (None, *Method)
        ),
    )
