"""FirstUses: slow first uses are spread over frames, quick ones are not."""

import pytest

from heatlens.render.display.first_uses import FirstUses


@pytest.mark.parametrize(("seconds", "frames"), [(0.001, 2), (0.1, 7), (0.015, 4)])
def test_frame_ends_after_a_slow_pass(seconds, frames):
    """Three passes are used once each and in their order, by as many frames as their time needs.

    A frame without a first use comes before them, and after each that was slow.
    """
    now, used = [0.0], []

    def make_use(name: int):
        def use() -> None:
            now[0] += seconds
            used.append(name)

        return use

    uses, passes = FirstUses(lambda: now[0]), [make_use(name) for name in range(3)]
    was_used = False
    for _ in range(frames - 1):
        used_before = len(used)
        assert not uses.run(passes) and uses.take_request()
        assert (len(used) == used_before) is not was_used
        was_used = not was_used
        assert not uses.take_request()  # asked for once, in case that nobody uses the rest
    assert uses.run(passes) and not uses.take_request()
    assert uses.run(passes) and used == [0, 1, 2]
