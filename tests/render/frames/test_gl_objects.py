"""Renderers leave no OpenGL objects behind; checks of contexts and of process growth."""

import pytest

from fuzz.soak import ProcessState, gl_objects, growth_faults
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from support import contexts
from support.plates import plate_of, room

LENS = Lens(85.0, 1.4, 2.0, 36.0)


@pytest.mark.parametrize("method", [it for it in Method if not it.needs_scene])
def test_unload_releases_gl_objects_of_all_plates(renderer, method):
    """Render plates of three sizes three times: the count of OpenGL objects does not grow."""
    shot = Shot(LENS, DefocusSettings(quality=Quality.PREVIEW, method=method))
    plates = [plate_of(*room(*size)) for size in ((32, 18), (48, 32), (33, 19))]
    object_counts = []
    for _ in range(3):
        for plate in plates:
            renderer.load(plate)
            renderer.render(shot)
        renderer.unload()
        object_counts.append(gl_objects())
    assert object_counts[1] == object_counts[2]


def test_contexts_made_lists_test_of_second_context(request, second_context):
    """Check the list of contexts by which `no_other_context` fails tests that make one."""
    assert contexts.contexts_made[-1].startswith(request.node.nodeid)


def test_growth_faults_reports_textures_and_memory():
    flat = [ProcessState(frames, 100_000_000, {"Textures": 4}) for frames in (10, 20, 30, 40)]
    assert growth_faults(flat) == []
    grown = ProcessState(frames=40, memory_bytes=100_000_000, objects={"Textures": 5})
    larger = ProcessState(frames=40, memory_bytes=200_000_000, objects={"Textures": 4})
    assert "{'Textures': 5}, not {'Textures': 4}" in growth_faults([*flat[:3], grown])[0]
    assert "memory grew by 100.0 MB" in growth_faults([*flat[:3], larger])[0]
