"""ScreenFrames: frames in display color, drawn once for a look, within a memory limit."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.render.display.screen_frames import ScreenFrames
from heatlens.render.gpu.resources import Texture

SIZES = ((4, 4), (8, 4), (16, 16))
# Key, its size, which look, and the keys that are wanted.
USE = st.lists(
    st.tuples(
        st.sampled_from("abcdef"),
        st.sampled_from(SIZES),
        st.integers(0, 2),
        st.frozensets(st.sampled_from("abcdef")),
    ),
    max_size=30,
)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 3000), USE)
def test_screen_frames_keep_limit_and_draw_each_look_once(ctx, limit_bytes, use):
    frames = ScreenFrames(ctx, limit_bytes)
    for key, size, look, wanted_keys in use:
        drawn = []

        def draw(out: Texture, value: int = 40 * ord(key) % 251 + look) -> None:
            drawn.append(out)  # noqa: B023  # called before the loop goes on
            out.write(bytes([value]) * (4 * out.width * out.height))

        was_there = frames.has_frame(key, (look,))
        texture = frames.texture(key, (look,), size, wanted_keys | {key}, draw)
        assert frames.bytes_in_use <= limit_bytes
        if texture is not None:
            assert texture.size == size and frames.has_frame(key, (look,))
            pixels = np.frombuffer(texture.read(), np.uint8)
            assert (pixels == 40 * ord(key) % 251 + look).all()
            assert was_there or len(drawn) == 1
    frames.clear()
    assert frames.bytes_in_use == 0
