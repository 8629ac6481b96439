"""Pictures drawn by wgpu are those of OpenGL, with the same shaders."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError, InputError, MissingPackageError, ShaderError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.color.color_config import LINEAR_REC709, load_color_config
from heatlens.media.color.view_transform import view_transform
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu import context
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram
from heatlens.render.gpu.textures import download, new_texture, upload
from heatlens.render.gpu.wgpu import spirv, wgpu_device
from support.both_ways import RasterAndRays
from support.command_line import ENVIRONMENT
from support.methods_of_plates import OF_PLATES
from support.plates import plate_of, wires_and_lamps
from support.scenes import still_life

SIZE = (160, 90)
LENS = Lens(85.0, 1.2, 1.6, 36.0)
SHOTS = {
    **{f"{quality.value}_quality": DefocusSettings(Bokeh.DISC, quality) for quality in Quality},
    **{method.value: DefocusSettings(method=method) for method in OF_PLATES},
    "half_size": DefocusSettings(Bokeh.DISC, Quality.FILM, proxy=0.5),
}


@pytest.fixture(scope="module")
def device():
    made = wgpu_device.headless_device()
    yield made
    made.release()


@pytest.fixture(scope="module")
def wgpu_renderer(device):
    return FrameRenderer(device)


def differences(picture: np.ndarray, by_opengl: np.ndarray) -> np.ndarray:
    """Return the differences, relative to the light where that is more than 1."""
    assert np.isfinite(picture).all() and by_opengl.std() > 0.01
    return np.abs(picture - by_opengl) / np.maximum(np.abs(by_opengl), 1.0)


def assert_same_picture(picture: np.ndarray, by_opengl: np.ndarray) -> None:
    """Compare pictures of plates: only the last bits of a product may differ."""
    differing = differences(picture, by_opengl)
    assert differing.max() <= 1e-4
    assert np.mean(differing <= 1e-5) >= 0.999


def assert_same_scene(picture: np.ndarray, by_opengl: np.ndarray) -> None:
    """Compare pictures of scenes, whose depths are equal but whose colors differ by last bits.

    Such a bit decides what a sample at an edge or a shadow shows, and how a half float is rounded.
    """
    differing = differences(picture, by_opengl)
    assert differing.max() <= 1e-3
    assert np.mean(differing <= 1e-4) >= 0.995


def picture_of_plate(renderer: FrameRenderer, shot: Shot) -> np.ndarray:
    renderer.load(plate_of(*wires_and_lamps(*SIZE)))
    return renderer.pixels(shot)


@pytest.mark.parametrize("name", SHOTS)
def test_wgpu_picture_of_plate_is_that_of_opengl(renderer, wgpu_renderer, name):
    shot = Shot(LENS, SHOTS[name])
    assert_same_picture(*(picture_of_plate(one, shot) for one in (wgpu_renderer, renderer)))


def test_wgpu_picture_by_blades_and_squeeze_is_that_of_opengl(renderer, wgpu_renderer):
    shot = Shot(Lens(85.0, 1.2, 1.6, 36.0, squeeze=1.6, blades=5, cat_eye=0.5))
    assert_same_picture(*(picture_of_plate(one, shot) for one in (wgpu_renderer, renderer)))


@contextmanager
def counted_as_gpus(*devices: Device) -> Iterator[None]:
    """Let renderers take the ways of drawing of a GPU."""
    with pytest.MonkeyPatch.context() as patch:
        for one in devices:
            patch.setattr(one, "is_software", False)
        yield


@pytest.fixture(scope="module")
def renderers_of_gpus(device, session_context):
    with counted_as_gpus(device, session_context):
        return FrameRenderer(device), FrameRenderer(session_context)


@pytest.mark.parametrize("quality", [Quality.FILM, Quality.FINAL])
def test_picture_in_the_ways_of_a_gpu_is_that_of_opengl_on_the_processor(
    renderer, renderers_of_gpus, device, session_context, quality
):
    shot = Shot(LENS, DefocusSettings(Bokeh.DISC, quality))
    on_processor = picture_of_plate(renderer, shot)
    with counted_as_gpus(device, session_context):
        by_wgpu, by_opengl = (picture_of_plate(one, shot) for one in renderers_of_gpus)
    assert_same_picture(by_wgpu, by_opengl)
    assert differences(by_wgpu, on_processor).max() <= 1e-4  # whose solver rounds otherwise


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.ACCUMULATION, Method.RAYTRACED])
def test_wgpu_picture_of_scene_is_that_of_opengl(renderer, wgpu_renderer, method):
    settings = DefocusSettings(method=method, views=4)
    shot = Shot(Lens(50.0, 1.4, 3.0, 36.0), settings, framing=Framing(80, 48))
    pictures = []
    for one in (wgpu_renderer, renderer):
        one.load_scene(still_life())
        pictures.append(one.pixels(shot))
    assert_same_scene(*pictures)


def test_scene_drawn_and_traced_by_wgpu_is_that_of_opengl(device, stage):
    by_wgpu = RasterAndRays(device)
    assert_same_scene(by_wgpu.seen(still_life()), stage.seen(still_life()))
    by_wgpu.release()


@pytest.mark.parametrize(("has_compiler", "most"), [(True, 1e-4), (False, 5e-3)])
def test_view_of_aces_is_drawn_by_wgpu_as_by_opengl(
    device, ctx, rng, monkeypatch, has_compiler, most
):
    """Lights over 14 stops and all colors; without a compiler from a table."""
    monkeypatch.setattr(wgpu_device, "has_compiler", lambda: has_compiler)
    transform = view_transform(
        load_color_config(None),
        "sRGB - Display",
        "ACES 2.0 - SDR 100 nits (Rec.709)",
        LINEAR_REC709[0],
    )
    light = (2 ** rng.uniform(-9, 5, (90, 160, 1)) * rng.uniform(0.3, 1, (90, 160, 3))).astype("f4")
    picture = np.concatenate([light, np.ones((90, 160, 1), np.float32)], axis=-1)
    values = []
    for one in (device, ctx):
        display, source = DisplayPass(one), new_texture(one, SIZE, 4)
        upload(source, picture)
        display.set_transform(transform)
        out = new_texture(one, SIZE, 4)
        display.run(source, out)
        values.append(download(out))
    assert np.abs(values[0] - values[1]).max() <= most


def test_mistake_in_shader_raises_error_with_file_and_reason(device, monkeypatch):
    def refused(*_args: object, **_words: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], 2, "ERROR: 'blur' : undeclared identifier", "")

    monkeypatch.setattr(spirv.subprocess, "run", refused)
    with pytest.raises(ShaderError, match=r"defocus/coc.comp.glsl.*undeclared identifier"):
        ComputeProgram(device, "defocus/coc.comp.glsl", {"UNKNOWN": 1}).link()


def test_missing_compiler_is_named_with_its_package(device, monkeypatch):
    def missing(*_args: object, **_words: object) -> None:
        raise FileNotFoundError(spirv.COMPILER)

    monkeypatch.setattr(spirv.subprocess, "run", missing)
    with pytest.raises(GpuError, match=r"glslangValidator.*glslang-tools"):
        ComputeProgram(device, "defocus/coc.comp.glsl", {"UNKNOWN": 2}).link()


def test_device_beyond_the_last_is_refused():
    with pytest.raises(GpuError, match="none has the number 99"):
        wgpu_device.headless_device(99)


def test_unknown_library_in_environment_is_refused(monkeypatch):
    monkeypatch.setenv("HEATLENS_GPU", "glide")
    with pytest.raises(InputError, match=r"HEATLENS_GPU is 'glide'.*auto, opengl, wgpu"):
        context.chosen_gpu()


class Failing:
    """Fails as a library without a device does."""

    def __call__(self, *_args: object) -> None:
        raise GpuError("nothing here")


@pytest.mark.parametrize("name", ["auto", "opengl", "wgpu"])
def test_auto_takes_wgpu_where_opengl_fails_and_a_choice_is_kept(monkeypatch, name):
    monkeypatch.setenv("HEATLENS_GPU", name)
    monkeypatch.setattr(context, "_opengl_device", Failing())
    monkeypatch.setattr(context, "_wgpu_device", lambda number: f"wgpu {number}")
    if name == "opengl":
        with pytest.raises(GpuError, match="nothing here"):
            context.headless_context()
    else:
        assert context.headless_context() == "wgpu 0"


@pytest.mark.parametrize("error", [GpuError("no device"), MissingPackageError("no wgpu")])
def test_auto_tells_what_opengl_needs_where_wgpu_fails_too(monkeypatch, error):
    def fail(_number: int) -> None:
        raise error

    monkeypatch.setenv("HEATLENS_GPU", "auto")
    monkeypatch.setattr(context, "_opengl_device", Failing())
    monkeypatch.setattr(context, "_wgpu_device", fail)
    with pytest.raises(GpuError, match="nothing here"):
        context.headless_context()


def test_render_by_wgpu_loads_no_opengl(tmp_path):
    code = """
import sys
from heatlens.fronts.commands.main import main
assert main(sys.argv[1:]) == 0
print(sorted({"moderngl", "glcontext"} & set(sys.modules)))
with open("/proc/self/maps") as maps:
    print([line for line in maps if "libGL." in line or "libEGL." in line])
"""
    plate = f"{wgpu_device.__file__.partition('app')[0]}assets/still_life.exr"
    words = ["render", plate, "-o", tmp_path / "out.exr", "--gpu", "wgpu", "--proxy", "0.25"]
    run = subprocess.run(
        [sys.executable, "-c", code, *map(str, words)],
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-2:] == ["[]", "[]"]
