"""A view transform as one table, for devices that cannot compile the GLSL of OpenColorIO.

The axes of the table are coded: nearly linear near black, logarithmic above. Light outside of the
table is clipped, where views have reached their white or their black.
"""

from dataclasses import replace

import numpy as np

from heatlens.media.color.view_transform import Lut, ViewTransform

# Entries along each axis. Measured with the ACES 2.0 view for SDR: off by 0.0022 at most, in 1 % by
# more than 0.0006. The table of a preview is off by 0.03 at most, on a plate by 0.008, in 1 % by
# more than 0.0018. The first takes 1.2 s of a processor, that of a preview 0.02 s.
SIDE, PREVIEW_SIDE = 129, 33
LOWEST, HIGHEST = -0.01, 128.0  # scene-linear light at the ends of the table
_SCALE = 128.0  # light is coded as asinh(128 light): logarithmic from about 1/128 on
_CODED_LOWEST, _CODED_HIGHEST = np.arcsinh(np.array([LOWEST, HIGHEST]) * _SCALE)


def table_glsl(side: int) -> str:
    """Return the GLSL that looks a view up in a table with this many entries along each axis."""
    entries_per_code = (side - 1) / (_CODED_HIGHEST - _CODED_LOWEST)
    return f"""
uniform sampler3D view_table_tx;

vec4 view_transform(vec4 light) {{
    vec3 scaled = clamp(light.rgb, vec3({LOWEST}), vec3({HIGHEST})) * {_SCALE};
    vec3 coded = sign(scaled) * log(abs(scaled) + sqrt(scaled * scaled + 1.0));
    vec3 entry = (coded - ({_CODED_LOWEST:.9g})) * {entries_per_code:.9g};
    return vec4(textureLod(view_table_tx, (entry + 0.5) / {float(side)}, 0.0).rgb, light.a);
}}
"""


def as_table(transform: ViewTransform, side: int = SIDE) -> ViewTransform:
    """Return the same view, drawn from a table of its values on the CPU."""
    coded = np.linspace(_CODED_LOWEST, _CODED_HIGHEST, side)
    levels = (np.sinh(coded) / _SCALE).astype(np.float32)
    blue, green, red = np.meshgrid(levels, levels, levels, indexing="ij")
    light = np.stack([red, green, blue], axis=-1).reshape(side * side, side, 3)
    values = transform.encode(light).reshape(side, side, side, 3)
    table = Lut("view_table_tx", values, is_linear=True)
    key = f"table of {side} of {transform.key}"
    return replace(transform, key=key, glsl=table_glsl(side), luts=(table,))
