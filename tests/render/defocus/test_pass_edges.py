"""Constants and boundary cases of the blur passes on which documents and budgets rely."""

from types import SimpleNamespace

import pytest

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.render.defocus import kernel_error
from heatlens.render.defocus.color_rounds import ColorRounds
from heatlens.render.defocus.fit_kernels import RIMS, fit_rims
from heatlens.render.defocus.highlights import highlight_list, highlight_split
from heatlens.render.defocus.kernel_error import DiscError
from heatlens.render.defocus.kernels import gaussian_kernel, named_kernel, rim_kernel
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.pass_costs import tiles_bytes, unmix_bytes
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.quality import kernel_for
from heatlens.render.defocus.reduced_plate import proxy_list_capacity
from heatlens.render.gpu.device import Device


@pytest.mark.parametrize(
    ("quality", "disc", "steps"),
    [(Quality.DRAFT, "disc_2", 2), (Quality.PREVIEW, "disc_3", 3), (Quality.FILM, "disc_4", 5)],
)
def test_kernel_for_quality_has_its_poles_and_steps(quality, disc, steps):
    def kernel(bokeh, **more):
        return kernel_for(DefocusSettings(bokeh, quality, **more))

    assert kernel(Bokeh.DISC).name == rim_kernel(disc, 0.0).name
    assert kernel(Bokeh.GAUSSIAN).name == gaussian_kernel(steps).name
    assert kernel(Bokeh.HEAT).name == named_kernel("heat").name
    assert kernel(Bokeh.DISC, method=Method.HEAT).name == named_kernel("heat").name


def test_unmix_bytes_grow_with_runs_and_tiles_bytes_do_not():
    one, four = unmix_bytes(None, 1), unmix_bytes(None, 4)
    assert (four.moved, four.least) == (4 * one.moved, 4 * one.least)
    assert one.moved == one.least == 6 and one.at_least  # coc and kind
    assert tiles_bytes(None, 1) == tiles_bytes(None, 4)


def test_constants_have_documented_values():
    assert highlight_list.SPRITES_MAX == 4096 and highlight_list.SMALL_SPRITES_MAX == 8192
    assert highlight_list._AREA_MAX == 24.0
    assert highlight_split.block_count((8, 8)) == 1 and highlight_split.block_count((9, 17)) == 6
    assert (kernel_error._FREQUENCY_MOST, kernel_error._RADII, kernel_error._ANGLES) == (
        *(60.0, 480, 12),
    )
    assert (kernel_error.LIGHT, kernel_error.VARIANCE) == (1.0, 1 / 16)


def test_fit_rims_fits_each_rim_with_its_disc_error():
    fits = fit_rims("disc_2")
    assert len(fits) == len(RIMS) and tuple(sorted(RIMS)) == RIMS
    for rim, fit in zip(RIMS, fits, strict=True):
        assert DiscError(1.0, rim).evaluate(fit.poles, fit.mix)[0] == pytest.approx(fit.error)
        assert len(fit.poles) == len(rim_kernel("disc_2", rim).poles)


class FakeColorPass:
    """A fake of the pass that copies color channels from one picture into another."""

    def __init__(self):
        self.taken = []

    def copy_channels(self, source, colors, out):
        self.taken.append((source, colors, out))


def test_color_rounds_run_red_and_blue_and_end_with_green():
    passes, seen = FakeColorPass(), []
    rounds = ColorRounds(passes)
    assert (rounds.done, rounds.count) == (0, 1)
    optics = SimpleNamespace(in_color=lambda color: color)
    scratch = SimpleNamespace(texture=lambda *_: "kept", end_pass=lambda name: name)

    def blurred(of):
        seen.append((of, rounds.done, rounds.count))
        yield "blur"
        return f"picture of {of.name}"

    steps, made = rounds.run_for_each_color(blurred, optics, (4, 4), scratch), []
    while True:
        try:
            made.append(next(steps))
        except StopIteration as end:
            assert end.value == "picture of GREEN"
            break
    assert [(of.name, done, count) for of, done, count in seen] == [
        ("RED", 0, 3), ("BLUE", 1, 3), ("GREEN", 2, 3),
    ]  # fmt: skip
    assert made == ["blur", "colours"] * 3
    red, blue, green = passes.taken
    assert red[0] == "picture of RED" and red[2] == "kept" == blue[2]
    assert [color.name for color in green[1]] == ["RED", "BLUE"]
    assert green[::2] == ("kept", "picture of GREEN")
    list(rounds.run_once(blurred, SimpleNamespace(name="ALL")))
    assert seen[-1][1:] == (0, 1)


def test_proxy_list_capacity_is_limited_by_buffer_size(ctx: Device):
    words = ctx.buffer(reserve=1200)
    whole = FragmentBuffers(
        starts=ctx.buffer(reserve=16), words=words, size=(2, 2), is_measured=False, is_exact=False
    )
    few, more = (proxy_list_capacity(ctx, whole, size) for size in ((1, 1), (10, 10)))
    each = (more - few) // 99
    assert few == 1200 // 12 + each and more == 1200 // 12 + 100 * each and each >= 1
    most = proxy_list_capacity(ctx, whole, (1 << 20, 1 << 20))
    assert most == ctx.limits.storage_block_bytes // 12
    words.release()
    whole.starts.release()


def test_proxy_size_keeps_aspect_and_at_least_one_pixel():
    assert proxy_size((100, 50), 0.5) == (50, 25) and proxy_size((100, 50), 1.0) == (100, 50)
    assert min(proxy_size((10, 3), 1 / 16)) >= 1
