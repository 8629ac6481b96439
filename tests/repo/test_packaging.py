"""Test that the wheel holds the code, shaders, kernels, page and assets, and correct metadata."""

import re
import subprocess
import sys
import zipfile
from email import message_from_string
from email.message import Message
from pathlib import Path

import trove_classifiers

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


def test_wheel_runs_from_outside_the_checkout(tmp_path: Path) -> None:
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--wheel-dir", str(tmp_path), str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("heatlens-*.whl")
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    shaders = {path.name for path in (ROOT / "shaders").rglob("*.glsl")}
    shipped = {path.name for path in (tmp_path / "site" / "heatlens" / "shaders").rglob("*.glsl")}
    assert shipped == shaders
    assets = {path.name for path in (tmp_path / "site" / "heatlens" / "assets").iterdir()}
    assert {"still_life.exr", "demo.glb"} <= assets
    assert assets.isdisjoint({"window.png", "demo_street"})
    modules = {path.name for path in (tmp_path / "site" / "heatlens").rglob("*")}
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
    } <= modules
    (metadata_path,) = (tmp_path / "site").glob("heatlens-*.dist-info/METADATA")
    check_metadata(message_from_string(metadata_path.read_text(encoding="utf-8")))
    code = (
        "import heatlens.core.base.paths as p;"
        "from heatlens.render.defocus.kernels import named_kernel;"
        "named_kernel('disc_4'); print(p.data_dir('shaders'), p.data_dir('assets'), p.__file__)"
    )
    run = subprocess.run(
        [
            sys.executable,
            "-I",
            "-c",
            f"import sys; sys.path.insert(0, {str(tmp_path / 'site')!r}); {code}",
        ],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=True,
    )
    assert all(str(tmp_path) in part for part in run.stdout.split())
