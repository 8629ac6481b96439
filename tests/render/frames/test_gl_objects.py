"""Whatever is rendered, OpenGL holds no more objects afterwards than it did before."""

import pytest

from fuzz.soak import Alive, faults, gl_objects
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from support import contexts
from support.plates import plate_of, room

LENS = Lens(85.0, 1.4, 2.0, 36.0)


@pytest.mark.parametrize("method", [it for it in Method if not it.needs_scene])
def test_other_plates_leave_no_objects_behind(renderer, method):
    """Every plate has buffers of its own, and what draws from them is made anew."""
    shot = Shot(LENS, DefocusSettings(quality=Quality.PREVIEW, method=method))
    plates = [plate_of(*room(*size)) for size in ((32, 18), (48, 32), (33, 19))]
    found = []
    for _ in range(3):
        for plate in plates:
            renderer.load(plate)
            renderer.render(shot)
        renderer.let_go()
        found.append(gl_objects())
    assert found[1] == found[2]


def test_another_context_is_noticed(request, second_context):
    """See `no_other_context`, which fails a test that does not say that it makes one."""
    assert contexts.made[-1].startswith(request.node.nodeid)


def test_growth_is_told():
    flat = [Alive(frames, 100_000_000, {"Textures": 4}) for frames in (10, 20, 30, 40)]
    assert faults(flat) == []
    more = Alive(40, 100_000_000, {"Textures": 5})
    larger = Alive(40, 200_000_000, {"Textures": 4})
    assert "{'Textures': 5}, not {'Textures': 4}" in faults([*flat[:3], more])[0]
    assert "memory grew by 100.0 MB" in faults([*flat[:3], larger])[0]
