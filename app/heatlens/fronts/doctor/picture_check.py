"""Render the still life that comes with heatlens, and compare it with the stored picture."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from heatlens.core.base.paths import data_dir
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.doctor.finding import Finding
from heatlens.media.color.color_config import load_color_config
from heatlens.media.color.view_transform import ViewTransform, view_transform
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.read import read_plate
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_texture, upload

SHOT = Shot(Lens(50.0, 1.4, 1.243, 36.0), DefocusSettings(proxy=0.25))
# A step of an 8-bit screen, relative to the light, or absolute if that is < 1.
MOST_DIFFERENCE = 1 / 255
MOST_OFF_SHARE = (
    0.005  # share of pixels that may be off by more: edges of discs, cuts between layers
)
COLOR_TOLERANCE = 1e-3  # in display values, between GPU and processor
TABLE_TOLERANCE = 5e-3  # the same where the GPU draws the view from a table


def stored_path() -> Path:
    """Return the path of the stored picture that the rendered one is compared with."""
    return data_dir("assets") / "doctor.exr"


def render_still_life(ctx: Device) -> FloatArray:
    """Render the picture on this machine, (H, W, 3)."""
    renderer = FrameRenderer(ctx)
    renderer.load(read_plate(data_dir("assets") / "still_life.exr"))
    return renderer.pixels(SHOT)[..., :3]


def still_life(ctx: Device) -> Iterator[Finding]:
    """Render the still life and compare it with the stored picture."""
    ((_, channels),) = read_parts(stored_path())
    expected = np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float32)
    picture = render_still_life(ctx)
    difference = np.abs(picture - expected) / np.maximum(1.0, np.abs(expected))
    share = float((~(difference.max(axis=2) <= MOST_DIFFERENCE)).mean())  # NaN counts as off
    message = (
        f"{100 * share:.2f} % of the pixels are off by more than {MOST_DIFFERENCE:.4f} "
        f"(allowed {100 * MOST_OFF_SHARE:g} %), the worst by {float(difference.max()):.4f}"
    )
    details = {"share_off": share, "worst": float(difference.max())}
    yield Finding("still life", "ok" if share <= MOST_OFF_SHARE else "fault", message, details)


def color(ctx: Device) -> Iterator[Finding]:
    """Compare OpenColorIO's default view on the GPU with the same view on the processor."""
    config = load_color_config(path=None)
    view = view_transform(
        config, config.default_display, config.default_view, config.default_input_space
    )
    light = np.random.default_rng(1).random((32, 32, 4), np.float32) * 4.0
    light[..., 3] = 1.0
    worst = float(np.abs(_display_on_gpu(ctx, view, light) - view.apply_cpu(light[..., :3])).max())
    message = (
        f"{config.source}: {view.view} on {view.display}, GPU and processor within {worst:.1e}"
    )
    details = {"config": config.source, "view": view.view, "worst": worst}
    allowed = COLOR_TOLERANCE if ctx.compiles_views else TABLE_TOLERANCE
    yield Finding("OpenColorIO", "ok" if worst <= allowed else "fault", message, details)


def _display_on_gpu(ctx: Device, view: ViewTransform, light: FloatArray) -> FloatArray:
    """Return the display values (H, W, 3) of `light` (H, W, 4), computed on the GPU."""
    size = (light.shape[1], light.shape[0])
    picture, display_tx = new_texture(ctx, size, 4), new_texture(ctx, size, 4)
    upload(picture, light)
    display_pass = DisplayPass(ctx)
    display_pass.set_transform(view)
    display_pass.run(picture, display_tx)
    display_values = download(display_tx)[..., :3]
    display_pass.release()
    picture.release()
    display_tx.release()
    return display_values
