"""A view transform as one table, for devices that cannot compile the GLSL of OpenColorIO.

The axes of the table are coded: nearly linear near black, logarithmic above. Light outside of the
table is clipped, where views have reached their white or their black.
"""

from dataclasses import replace

import numpy as np

from heatlens.media.color.view_transform import Lut, ViewTransform

# Measured with the ACES 2.0 view for SDR: off by 0.0022 at most, in 1 % by more than 0.0006.
SIDE = 129  # entries along each axis
LOWEST, HIGHEST = -0.01, 128.0  # scene-linear light at the ends of the table
_SCALE = 128.0  # light is coded as asinh(128 light): logarithmic from about 1/128 on
_CODED_LOWEST, _CODED_HIGHEST = np.arcsinh(np.array([LOWEST, HIGHEST]) * _SCALE)
_ENTRIES_PER_CODE = (SIDE - 1) / (_CODED_HIGHEST - _CODED_LOWEST)
TABLE_GLSL = f"""
uniform sampler3D view_table_tx;

vec4 view_transform(vec4 light) {{
    vec3 scaled = clamp(light.rgb, vec3({LOWEST}), vec3({HIGHEST})) * {_SCALE};
    vec3 coded = sign(scaled) * log(abs(scaled) + sqrt(scaled * scaled + 1.0));
    vec3 entry = (coded - ({_CODED_LOWEST:.9g})) * {_ENTRIES_PER_CODE:.9g};
    return vec4(textureLod(view_table_tx, (entry + 0.5) / {float(SIDE)}, 0.0).rgb, light.a);
}}
"""


def as_table(transform: ViewTransform) -> ViewTransform:
    """Return the same view, drawn from a table of its values on the CPU."""
    coded = np.linspace(_CODED_LOWEST, _CODED_HIGHEST, SIDE)
    levels = (np.sinh(coded) / _SCALE).astype(np.float32)
    blue, green, red = np.meshgrid(levels, levels, levels, indexing="ij")
    light = np.stack([red, green, blue], axis=-1).reshape(SIDE * SIDE, SIDE, 3)
    values = transform.encode(light).reshape(SIDE, SIDE, SIDE, 3)
    table = Lut("view_table_tx", values, is_linear=True)
    return replace(transform, key=f"table of {transform.key}", glsl=TABLE_GLSL, luts=(table,))
