"""A whole picture is issued to a device that is not OpenGL: no pass asks which it is."""

import pytest

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.lab.measure.bench.issues import measure_issues
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.render.defocus.line_solver import SolverName
from support.fake_device import FakeDevice

FILM = DefocusSettings(Bokeh.DISC, Quality.FILM)
SIZE = (160, 90)


@pytest.mark.usefixtures("of_opengl")
def test_fake_device_runs_whole_film_frame(ctx):
    device = FakeDevice()
    frame = BenchFrames(device, SolverName.PARTITION).frame(scene_plate(SIZE), LENS, FILM)
    frame.render()
    first_frame_bytes = device.made_bytes
    device.calls.clear()
    assert frame.render().size == SIZE
    assert device.made_bytes == first_frame_bytes  # a second frame takes no further memory
    counted = measure_issues(ctx, SIZE, FILM, 1, lambda _: None)
    for kind, count in {
        "dispatch": counted.dispatches,
        "indirect": counted.indirect_dispatches,
        "draw": counted.draws,
        "clear": counted.clears,
    }.items():
        assert device.calls.count_of(kind) == count
    assert device.calls.count_of("bind") == device.calls.count_of("dispatch", "indirect", "draw")
    assert ("dispatch", "defocus/coc.comp.glsl") in device.calls
