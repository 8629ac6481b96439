"""Shared fixtures: one OpenGL context for the session, clean before and after every test.

What draws is imported inside the fixtures that draw, so that `pytest tests/model` needs no OpenGL.
"""

import gc
import os
import re
import signal
import sys
import tempfile
from collections.abc import Generator, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np
import pytest
from hypothesis import settings

from heatlens.core.base import faults
from support import contexts
from support.command_line import ENVIRONMENT, kill_started_processes

if TYPE_CHECKING:
    from heatlens.render.frame_renderer import FrameRenderer
    from heatlens.render.gpu.device import Device
    from heatlens.render.scene_gpu.raster import SceneRaster
    from support.both_ways import RasterAndRays
    from support.gui import Gui


# The same code, the same verdict, also on a busy machine; `pytest --hypothesis-profile=default`
# looks for new cases, twice as many.
settings.register_profile("repeated", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("repeated")


def pytest_configure(config: pytest.Config) -> None:
    """Move the user's folders away, so that no test reads or changes real preferences."""
    # xdist would start files of few tests last; a few of them are the longest, and one ran alone.
    config.option.loadscopereorder = False
    folder = Path(tempfile.gettempdir()) / f"heatlens-tests-{os.getpid()}"
    os.environ["HEATLENS_GPU"] = config.getoption("--gpu")
    os.environ["HEATLENS_CONFIG_DIR"] = str(folder / "preferences")
    os.environ["HEATLENS_LOG_DIR"] = str(folder / "reports")
    os.environ["HEATLENS_CACHE_DIR"] = str(folder / "cache")
    os.environ["HEATLENS_RUNTIME_DIR"] = str(folder / "run")
    share_compiled_shaders(folder / "cache")
    # gpu.program: an input of a shader that is never given is an error.
    os.environ["HEATLENS_STRICT_SHADERS"] = "1"
    # Hundreds of processes start the program; compiled once, its modules serve them all.
    sys.dont_write_bytecode = False
    for environment in (os.environ, ENVIRONMENT):
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
    heard_by_children()


def share_compiled_shaders(cache_folder: Path) -> None:
    """Let the workers of one run share their SPIR-V; the name of a file tells its content."""
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID")
    if run is not None:
        shared = Path(tempfile.gettempdir()) / f"heatlens-tests-{run}"
        shared.mkdir(exist_ok=True)
        cache_folder.mkdir(parents=True, exist_ok=True)
        with suppress(FileExistsError):  # of an earlier process of the same number
            (cache_folder / "shaders").symlink_to(shared)


def heard_by_children() -> None:
    """Let what the tests start obey every signal, whatever started the tests.

    A shell's background ignores Ctrl-C, and nohup that the terminal has gone; both would be handed
    on. A signal with a handler has its usual effect in a child, and none here.
    """
    for name in ("SIGHUP", "SIGTERM", "SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGTSTP", "SIGCHLD"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect without the garbage collector, and keep it from what was collected.

    Ten thousand tests live until the end of the run, in every worker; to look at them again and
    again took an eighth of the time of the collection.
    """
    gc.disable()
    result = yield
    gc.freeze()
    gc.enable()
    return result


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """Let `-n auto` start one worker more than there are processors.

    A quarter of the time a test waits: for a process, a browser, Slurm, or what rests.
    """
    return (yield) + 1


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--update-golden`, which rewrites the golden pictures, and three more options."""
    help_text = "skip tests that draw, with a fixture or the mark `draws_in_process`"
    parser.addoption("--without-opengl", action="store_true", help=help_text)
    parser.addoption("--gpu", default="opengl", help="draw with this: opengl or wgpu")
    parser.addoption("--fuzz-minutes", type=float, help="fuzz each format for so long")
    parser.addoption(
        "--update-golden", action="store_true", help="rewrite tests/render/frames/golden/"
    )


@pytest.fixture(autouse=True)
def no_fault_is_hidden(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test in which heatlens caught a fault of its own, unless it is about that."""
    faults._reports_by_location.clear()
    yield
    written, about = dict(faults._reports_by_location), "expects_faults" in request.fixturenames
    faults._reports_by_location.clear()
    assert about or not written, {at: path and path.read_text() for at, path in written.items()}


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip a test whose own processes draw, on a machine without OpenGL."""
    draws = item.get_closest_marker("draws_in_process") is not None
    if draws and item.config.getoption("--without-opengl"):
        skip_what_draws()


@pytest.fixture(autouse=True)
def no_process_is_left() -> Iterator[None]:
    """Close what `support.command_line.started` started, also where the test failed."""
    yield
    kill_started_processes()


@pytest.fixture(autouse=True)
def no_other_context(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that makes an OpenGL context here, unless it asks for `second_context`.

    The new one would stay the current one, and what later tests draw would go there.
    """
    before = len(contexts.contexts_made)
    yield
    assert "second_context" in request.fixturenames or contexts.contexts_made[before:] == []


@pytest.fixture
def second_context(session_context: "Device") -> Iterator["Device"]:
    """Make another context, and leave that of the run the current one."""
    from heatlens.render.gpu.opengl import gl_device

    made = gl_device.headless_device()
    yield made
    session_context.make_current()
    made.release()


@pytest.fixture
def expects_faults() -> None:
    """Mark a test in which something fails in a way that nobody foresaw."""


def skip_what_draws() -> NoReturn:
    """Skip a test that asks for OpenGL on a machine without it."""
    pytest.skip("draws, and --without-opengl was given")


@pytest.fixture(scope="session")
def session_context(pytestconfig: pytest.Config) -> Iterator["Device"]:
    """Make the one OpenGL context of the run; making one costs 0.2 s."""
    from heatlens.render.gpu.context import headless_context

    if pytestconfig.getoption("--without-opengl"):
        skip_what_draws()
    ctx = headless_context()
    contexts.list_unheld(ctx)
    yield ctx
    ctx.release()


@pytest.fixture
def ctx(session_context: "Device") -> Iterator["Device"]:
    """Return the context, and check that a test finds and leaves no OpenGL error."""
    assert session_context.error == ""
    yield session_context
    assert session_context.error == ""


@pytest.fixture
def of_opengl(session_context: "Device") -> None:
    """Skip a test of what only OpenGL does where another library draws."""
    if session_context.library != "OpenGL":
        pytest.skip("tests OpenGL")


@pytest.fixture(scope="module")
def raster(session_context: "Device") -> Iterator["SceneRaster"]:
    """Return what draws scenes as a raster."""
    from heatlens.render.scene_gpu.raster import SceneRaster

    made = SceneRaster(session_context)
    yield made
    made.release()


@pytest.fixture(scope="module")
def stage(session_context: "Device") -> Iterator["RasterAndRays"]:
    """Return what draws scenes as a raster and traces them by rays."""
    from support.both_ways import RasterAndRays

    made = RasterAndRays(session_context)
    yield made
    made.release()


def _release_unheld(ctx: "Device") -> None:
    """Release what OpenGL holds and Python does not: a run of all tests would take 20 GB."""
    gc.collect()
    gc.freeze()  # what is alive now is not looked at again: late in a run that takes seconds
    contexts.release_unheld(ctx)


@pytest.fixture(scope="module", autouse=True)
def memory_of_one_file(command_context: "Device | None") -> Iterator[None]:
    """Give back after each test file what its pictures and programs took."""
    yield
    if command_context:
        _release_unheld(command_context)


_IMPORTED = r"import [^()]*\(?[^()]*\bheadless_context"


@pytest.fixture(scope="session", autouse=True)
def command_context(
    request: pytest.FixtureRequest, pytestconfig: pytest.Config
) -> Iterator["Device | None"]:
    """Make the commands that run inside the tests draw with the context of the session.

    A context of their own would become the current one, and calls for this one would go there.
    """
    import heatlens

    draws = not pytestconfig.getoption("--without-opengl")
    device = request.getfixturevalue("session_context") if draws else None
    root = Path(heatlens.__file__).parent
    with pytest.MonkeyPatch.context() as patch:
        contexts.record_new_contexts(patch)
        for path in root.rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            # The search alone backtracks for seconds over files without the name.
            if "headless_context" in text and re.search(_IMPORTED, text):
                module = ".".join(path.relative_to(root.parent).with_suffix("").parts)
                patch.setattr(f"{module}.headless_context", lambda: device or skip_what_draws())
        yield device


@pytest.fixture(scope="module")
def renderer(session_context: "Device") -> "FrameRenderer":
    """Make one renderer a test file: it builds the shaders."""
    from heatlens.render.frame_renderer import FrameRenderer

    return FrameRenderer(session_context)


@pytest.fixture(scope="module")
def room_window(
    session_context: "Device", tmp_path_factory: pytest.TempPathFactory
) -> Iterator["Gui"]:
    """Open one window a test file, which shows the room with the fastest blur."""
    from support.gui import gui_of  # here: command line tests need no ImGui
    from support.session_files import QUICK, room_file

    plate = room_file(tmp_path_factory.mktemp("window") / "room.exr")
    with gui_of(session_context, plate, defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def gui(ctx: "Device", room_window: "Gui") -> "Gui":
    """Return that window in the state in which it was opened."""
    room_window.begin_again()
    return room_window


@pytest.fixture
def shot_file(tmp_path: Path) -> Path:
    """Write a shot and its six tiny plates, and return the path of the shot."""
    from support.exports import write_shot_file

    return write_shot_file(tmp_path)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Return the pattern of exported frames, in a folder that does not exist yet."""
    return tmp_path / "out" / "n.####.exr"


@pytest.fixture
def usd_path(tmp_path: Path) -> Path:
    """Return the path of a USD camera that is not written yet."""
    return tmp_path / "cam.usda"


@pytest.fixture
def small_demo(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the demo scene by a small one that is seen in few pixels."""
    import heatlens.media.scene.demo
    from heatlens.core.model.lens.lens import Lens
    from heatlens.core.model.shot.framing import Framing
    from heatlens.core.model.shot.shot import Shot
    from support.scenes import still_life

    shot = Shot(Lens(50.0, 2.0, 3.0, 36.0), framing=Framing(80, 48, "camera"))
    monkeypatch.setattr(heatlens.media.scene.demo, "demo_scene", still_life)
    monkeypatch.setattr(heatlens.media.scene.demo, "demo_shot", lambda: shot)


@pytest.fixture
def rng() -> np.random.Generator:
    """Return a random generator that gives the same numbers in each run."""
    return np.random.default_rng(20060106)


@pytest.fixture(autouse=True)
def numpy_raises() -> Iterator[None]:
    """Make NumPy raise: a NaN that is made silently is a black pixel in a film."""
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield
