"""Test that the wheel holds the code, shaders, kernels, page and assets, and correct metadata."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from email import message_from_string
from email.message import Message
from pathlib import Path
from types import SimpleNamespace

import pytest
import trove_classifiers

from heatlens.fronts.doctor import compiled_shaders
from heatlens.fronts.doctor.gpu_check import pass_builds, solver_builds
from heatlens.render.gpu.wgpu.reflection import reflect
from heatlens.render.gpu.wgpu.spirv import COMPILER, PACKED

ROOT = Path(__file__).resolve().parents[2]


def check_metadata(metadata: Message) -> None:
    """Check the metadata for package indexes: real facts and no address."""
    assert metadata["License-Expression"] == "MIT" and "depth of field" in metadata["Keywords"]
    assert not metadata.get_all("Project-URL") and not metadata["Home-page"]
    assert metadata["Author"] == "heatlens developers"
    classifiers = metadata.get_all("Classifier") or []
    known = {"Typing :: Typed", "Operating System :: POSIX :: Linux"}
    assert known <= set(classifiers) <= set(trove_classifiers.classifiers)
    requirements = metadata.get_all("Requires-Dist") or []
    assert any(line.startswith("platformdirs") for line in requirements)
    extras = {
        name: packages_of(name, requirements) for name in metadata.get_all("Provides-Extra") or []
    }
    assert {"matplotlib", "flip-evaluator"} <= extras["study"]
    of_users = (extras[name] for name in extras.keys() - {"all", "fit", "test"})
    assert extras["all"] == set().union(*of_users) and extras["all"] <= extras["test"]
    assert extras["desk-free"] == extras["desk"] - {"av"} and "av" in extras["desk"]
    assert not extras["desk"] & {"opencv-python-headless", "usd-core", "onnxruntime", "distributed"}


def packages_of(extra: str, requirements: list[str]) -> set[str]:
    """Return the names of the packages that an extra installs."""
    lines = [line for line in requirements if line.endswith(f"extra == '{extra}'")]
    return {re.split(r"[^\w.-]", line)[0] for line in lines}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this checkout; also unpacked in the folder `site` beside it."""
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--wheel-dir", str(folder), str(ROOT)], check=True)
    (file,) = folder.glob("heatlens-*.whl")
    zipfile.ZipFile(file).extractall(folder / "site")
    return file


def run_wheel(wheel: Path, code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run Python with the unpacked wheel first on its path, in a folder outside the checkout."""
    site = f"import sys; sys.path.insert(0, {str(wheel.parent / 'site')!r}); "
    return subprocess.run(
        [sys.executable, "-I", "-c", site + code],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        cwd=wheel.parent,
        check=False,
    )


def test_wheel_holds_code_data_and_metadata(wheel: Path) -> None:
    site = wheel.parent / "site"
    shaders = {path.name for path in (ROOT / "shaders").rglob("*.glsl")}
    shipped = {path.name for path in (site / "heatlens" / "shaders").rglob("*.glsl")}
    assert shipped == shaders
    assets = {path.name for path in (site / "heatlens" / "assets").iterdir()}
    assert {"still_life.exr", "demo.glb"} <= assets
    assert assets.isdisjoint({"window.png", "demo_street"})
    modules = {path.name for path in (site / "heatlens").rglob("*")}
    assert {
        "options.md",
        "plates.md",
        "py.typed",
        "disc_kernels.json",
        "rim_kernels.json",
        "macro.json",
        "page.html.jinja",
        "page.css",
        "index.html",
        PACKED,
    } <= modules
    (metadata_path,) = site.glob("heatlens-*.dist-info/METADATA")
    check_metadata(message_from_string(metadata_path.read_text(encoding="utf-8")))
    assert wheel.stat().st_size <= 8e6


def test_wheel_runs_from_outside_the_checkout(wheel: Path) -> None:
    code = (
        "import heatlens.core.base.paths as p;"
        "from heatlens.render.defocus.kernels import named_kernel;"
        "named_kernel('disc_4'); print(p.data_dir('shaders'), p.data_dir('assets'), p.__file__)"
    )
    words = run_wheel(wheel, code).stdout.split()
    assert len(words) == 3 and all(str(wheel.parent) in word for word in words)


def test_wheel_draws_by_wgpu_without_compiler(wheel: Path, tmp_path: Path) -> None:
    code = """
from heatlens.core.base.paths import data_dir
from heatlens.fronts.commands.main import main
plate = str(data_dir("assets") / "still_life.exr")
sys.exit(main(["render", plate, "-o", "out.png", "--gpu", "wgpu", "--proxy", "0.25"]))
"""
    run = run_wheel(wheel, code, PATH=str(tmp_path), HEATLENS_CACHE_DIR=str(tmp_path))
    assert run.returncode == 0, run.stderr
    assert not list(tmp_path.rglob("*.spv"))
    assert (wheel.parent / "out.png").is_file()


@pytest.mark.skipif(shutil.which("spirv-cross") is None, reason="apt-get install spirv-cross")
def test_compiled_shaders_become_shaders_of_metal_and_of_direct3d(wheel, tmp_path) -> None:
    """wgpu translates by naga, not by spirv-cross; this shows that a translation exists."""
    zipfile.ZipFile(wheel.parent / "site/heatlens/shaders" / PACKED).extractall(tmp_path)
    languages = (["--msl", "--msl-version", "20200"], ["--hlsl", "--shader-model", "60"])
    words = [
        ["spirv-cross", str(file), *language, "--output", os.devnull]
        for file in tmp_path.glob("*.spv")
        for language in languages
    ]

    def complaint_of(command: list[str]) -> str:
        return subprocess.run(command, capture_output=True, text=True, check=False).stderr

    with ThreadPoolExecutor() as pool:
        assert set(pool.map(complaint_of, words)) == {""}
    assert len(words) > 2 * len(solver_builds() + pass_builds())


def test_images_read_and_written_have_formats_that_metal_reads_and_writes(wheel) -> None:
    """Those of Metal's textures of tier 2, which all Apple silicon has."""
    formats = {"r32float", "r32uint", "r16float", "rgba8unorm"}
    formats |= {"rgba16float", "rgba32float", "rgba32uint"}
    archive = zipfile.ZipFile(wheel.parent / "site/heatlens/shaders" / PACKED)
    images = [
        (str(one.layout["format"]), one.name)
        for name in archive.namelist()
        for one in reflect(archive.read(name)).bindings
        if one.layout.get("access") == "read-write"
    ]
    assert (
        images and {(format_, name) for format_, name in images if format_ not in formats} == set()
    )


class Hook:
    """The build hook of a package, with what hatchling gives it and gets from it."""

    def __init__(self, root: Path, target: str) -> None:
        path = ROOT / "app/packing/compile_shaders.py"
        spec = importlib.util.spec_from_file_location("compile_shaders", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        self.warnings, self.files = [], {}
        app = SimpleNamespace(display_warning=self.warnings.append)
        self._hook = module.CompileShaders(str(root), {}, None, None, "", target, app)

    def run(self, version: str) -> dict[str, bytes]:
        """Return the files that the hook adds, by their places."""
        data = {"force_include": {}}
        self._hook.initialize(version, data)
        files = {place: Path(file).read_bytes() for file, place in data["force_include"].items()}
        self._hook.finalize(version, data, "")
        assert not any(Path(file).exists() for file in data["force_include"])
        return files


@pytest.fixture
def quick_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled_shaders, "packed_shaders", lambda: b"all shaders")


@pytest.mark.usefixtures("quick_compiler")
def test_wheel_and_sdist_get_the_same_shaders_and_an_editable_install_none(tmp_path: Path) -> None:
    wheel, sdist = (Hook(tmp_path, target) for target in ("wheel", "sdist"))
    assert wheel.run("standard") == {f"heatlens/shaders/{PACKED}": b"all shaders"}
    assert sdist.run("standard") == {f"shaders/{PACKED}": b"all shaders"}
    assert wheel.run("editable") == {} and wheel.warnings == []


@pytest.mark.usefixtures("quick_compiler")
def test_wheel_of_sdist_takes_the_shaders_that_lie_there(tmp_path: Path) -> None:
    (tmp_path / "shaders").mkdir()
    (tmp_path / "shaders" / PACKED).write_bytes(b"from the sdist")
    assert Hook(tmp_path, "wheel").run("standard") == {}


@pytest.mark.usefixtures("quick_compiler")
def test_package_without_compiler_is_made_with_a_warning(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    hook = Hook(tmp_path, "wheel")
    assert hook.run("standard") == {} and COMPILER in hook.warnings[0]
