"""Breathing: how the view of a lens changes as it is focused.

Most lenses show less when they are focused nearer. The width of the view is linear in the dioptres
of the focus, from its value at infinity to `Lens.breathing` times that at close focus. The picture
is that of a lens of another focal length with an opening of the same diameter.
"""

from dataclasses import replace

from heatlens.core.model.lens.lens import Lens

USUAL_CLOSE_M = 0.5  # if the close focus of a lens is unknown


def view_ratio(lens: Lens) -> float:
    """Return the width of the view over that at infinity; 1 for a lens that does not breathe.

    Nearer than close focus it is constant.
    """
    if lens.breathing == 1.0:
        return 1.0
    close_m = USUAL_CLOSE_M if lens.close_focus_m is None else lens.close_focus_m
    return 1.0 + (lens.breathing - 1.0) * min(1.0, close_m / lens.focus_distance_m)


def without_breathing(lens: Lens) -> Lens:
    """Return a lens with the same view and no breathing; its focal length and f-stop differ.

    The diameter of the opening stays the same, and so do the discs relative to the view.
    """
    ratio = view_ratio(lens)
    if lens.breathing == 1.0:
        return lens
    widest_f_stop = None if lens.widest_f_stop is None else lens.widest_f_stop / ratio
    return replace(
        lens,
        focal_length_mm=lens.focal_length_mm / ratio,
        f_stop=lens.f_stop / ratio,
        widest_f_stop=widest_f_stop,
        breathing=1.0,
    )


def plate_ratio(lens: Lens, overscan_ratio: float) -> float:
    """Return the width of the frame that a picture of a plate shows.

    `overscan_ratio` is the width of the plate divided by that of its frame, 1 without overscan. A
    view that would become wider than the plate is scaled by the same factor at every focus.
    """
    return view_ratio(lens) / max(1.0, lens.breathing / max(overscan_ratio, 1.0))


def breathing_note(lens: Lens, overscan_ratio: float | None) -> str:
    """Return a sentence on the effect of breathing on a picture; "" for a lens without it.

    `overscan_ratio` is as in `plate_ratio`; None for a scene, which is drawn as the lens sees it.
    """
    if lens.breathing == 1.0:
        return ""
    change = f"{100 * abs(1 - lens.breathing):.3g} %"
    less_or_more = "less" if lens.breathing < 1 else "more"
    first_clause = (
        f"The lens breathes: at close focus it shows {change} {less_or_more} than at infinity"
    )
    if overscan_ratio is None:
        return f"{first_clause}."
    if lens.breathing < 1:
        return f"{first_clause}, which is cut from the plate."
    if overscan_ratio >= lens.breathing:
        return f"{first_clause}, which the overscan of the plate has."
    scale = lens.breathing / max(overscan_ratio, 1.0)
    return (
        f"{first_clause}, and the plate has no overscan for that: every frame is enlarged "
        f"{scale:.3g}x."
    )
