"""What is installed is whole: a wheel carries the code, its shaders, kernels and plate."""

import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_wheel_runs_from_outside_the_checkout(tmp_path: Path) -> None:
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--wheel-dir", str(tmp_path), str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("heatlens-*.whl")
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    shaders = {path.name for path in (ROOT / "shaders").rglob("*.glsl")}
    shipped = {path.name for path in (tmp_path / "site" / "heatlens" / "shaders").rglob("*.glsl")}
    assert shipped == shaders
    assets = {path.name for path in (tmp_path / "site" / "heatlens" / "assets").iterdir()}
    assert "still_life.exr" in assets and "window.png" not in assets
    code = (
        "import heatlens.paths as p; from heatlens.defocus.kernels import named_kernel;"
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
