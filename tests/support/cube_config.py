"""A config whose views go through tables in files, written for a test."""

from pathlib import Path

import numpy as np

from heatlens.media.color.color_config import ColorConfig, load_color_config

CUBE_CONFIG = """ocio_profile_version: 2
roles: {default: plain, scene_linear: plain}
displays:
  Screen:
    - !<View> {name: linear, colorspace: linear}
    - !<View> {name: tetrahedral, colorspace: tetrahedral}
    - !<View> {name: curve, colorspace: curve}
colorspaces:
  - !<ColorSpace> {name: plain, encoding: scene-linear}
"""


def cube_config(folder: Path) -> ColorConfig:
    """Write an OCIO config with views through 5x5x5 cubes and a 9-entry curve. Return it loaded."""
    rng = np.random.default_rng(5)
    entries = "\n".join(f"{r:.6f} {g:.6f} {b:.6f}" for r, g, b in rng.uniform(0, 1, (125, 3)))
    (folder / "film.cube").write_text(f"LUT_3D_SIZE 5\n{entries}\n")
    steps = "\n".join(f"{x:.6f} {x**2:.6f} {1 - x:.6f}" for x in np.linspace(0, 1, 9))
    (folder / "curve.cube").write_text(f"LUT_1D_SIZE 9\n{steps}\n")
    text = CUBE_CONFIG
    for name in ("linear", "tetrahedral"):
        film = f"!<FileTransform> {{src: film.cube, interpolation: {name}}}"
        text += f"  - !<ColorSpace> {{name: {name}, from_scene_reference: {film}}}\n"
    curve = "!<FileTransform> {src: curve.cube}"
    text += f"  - !<ColorSpace> {{name: curve, from_scene_reference: {curve}}}\n"
    (folder / "studio.ocio").write_text(text)
    return load_color_config(str(folder / "studio.ocio"))
