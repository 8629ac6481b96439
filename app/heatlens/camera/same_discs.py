"""Compute the f-stop with which a renderer makes the discs that heatlens showed.

A real lens makes larger discs than a renderer with the same f-stop (see `LensModel`), so the
renderer gets a wider f-stop; the nominal f-stop is kept beside it.
"""

from dataclasses import replace

from heatlens.camera.samples import CameraSamples, is_constant
from heatlens.model.lens.lens_model import LensModel


def with_renderer_f_stop(camera: CameraSamples) -> CameraSamples:
    """Return the camera with the f-stop that makes the same discs in a renderer, and the nominal.

    It is N (1 - f/S) at each frame, and a note says so. A camera that has the discs of a renderer
    already, or lacks the f-stop, the focus or the focal length, is returned unchanged.
    """
    f_stops, focals, focus = camera.f_stop, camera.focal_length_mm, camera.focus_distance_m
    model = camera.lens_model
    if model in (None, LensModel.RENDERER) or camera.nominal_f_stop is not None:
        return camera
    if f_stops is None or focals is None or focus is None:
        return camera
    told = tuple(
        n * model.focal_over_image_distance(f_mm, s_m)
        for n, f_mm, s_m in zip(f_stops, focals, focus, strict=True)
    )
    note = (
        f"f-stop written as {_span(told)}, with which a CG renderer makes the discs of this "
        f"{model.facts.words} at {_span(f_stops)}; the nominal value is kept beside it, and "
        "`--f-stop nominal` writes it instead."
    )
    return replace(camera, f_stop=told, nominal_f_stop=f_stops, notes=(*camera.notes, note))


def with_nominal_f_stop(camera: CameraSamples) -> CameraSamples:
    """Return the camera with only the nominal f-stop, which is marked on the lens."""
    if camera.nominal_f_stop is None:
        return camera
    return replace(camera, f_stop=camera.nominal_f_stop, nominal_f_stop=None)


def _span(f_stops: tuple[float, ...]) -> str:
    ends = f"f/{min(f_stops):.4g}", f"f/{max(f_stops):.4g}"
    return ends[0] if is_constant(f_stops) else f"{ends[0]} to {ends[1]}"
