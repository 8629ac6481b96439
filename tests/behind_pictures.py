"""Draw the two pictures of README.md that show what lies behind a blurred thing, and measure them.

    .venv/bin/python tests/behind_pictures.py

A shelf of books stands behind leaves. Its pinhole picture is blurred as a flat plate, whose hidden
surfaces are guessed, and with the shelf without leaves as `--behind`; both are compared with many
views through the lens. All is done by the commands that a user has.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

ASSETS = Path(__file__).parents[1] / "assets"
SIZE, CROP = (960, 540), (240, 120, 720, 424)  # px; left, upper, right, lower of what is shown
VIEWS, OVERSCAN_PX = 256, 40
LENS = ("--focus-distance", "2.6", "--f-stop", "1.4")
_SHELF_M, _LEAVES_M = 2.7, (0.75, 1.1)  # distances from the camera
_LEAVES = 20


def colored(mesh: trimesh.Trimesh, color: np.ndarray) -> trimesh.Trimesh:
    """Return a mesh with one colour, linear red, green and blue from 0 to 1."""
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[*color, 1.0], metallicFactor=0.0, roughnessFactor=1.0, doubleSided=True
    )
    mesh.visual = trimesh.visual.TextureVisuals(material=material)
    return mesh


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> trimesh.Trimesh:
    """Return a box between two corners in m."""
    return trimesh.creation.box(bounds=[low, high])


def shelf(rng: np.random.Generator) -> list[trimesh.Trimesh]:
    """Return boards, a back and rows of books with labels; x to the right, y up, -z ahead."""
    back, front = -_SHELF_M - 0.25, -_SHELF_M
    parts = [colored(block((-2, -1, back - 0.02), (2, 1, back)), np.array([0.03, 0.02, 0.02]))]
    for floor in np.arange(-0.9, 0.9, 0.36):
        board = block((-2, floor - 0.03, back), (2, floor, front))
        parts.append(colored(board, np.array([0.22, 0.11, 0.06])))
        left = -2.0
        while left < 2.0:
            width = rng.uniform(0.035, 0.075)
            parts += book(rng, (left, floor, back), width, front - rng.uniform(0.0, 0.06))
            left += width
    return parts


def book(
    rng: np.random.Generator, corner: tuple[float, float, float], width: float, spine: float
) -> list[trimesh.Trimesh]:
    """Return a book from its lower left corner at the back to its spine, and its label, in m."""
    (left, floor, back), height = corner, rng.uniform(0.2, 0.3)
    paint = np.array(trimesh.visual.color.hsv_to_rgba([[rng.uniform(), 0.7, 0.8]])[0][:3])
    paint = (paint / max(paint.max(), 1) * rng.uniform(0.4, 1.0)) ** 1.3
    cover = block((left, floor, back), (left + 0.95 * width, floor + height, spine))
    low = (left + 0.2 * width, floor + 0.6 * height, spine)
    high = (left + 0.75 * width, floor + 0.7 * height, spine + 1e-3)
    return [colored(cover, paint), colored(block(low, high), np.array([0.7, 0.68, 0.6]))]


def leaves(rng: np.random.Generator) -> list[trimesh.Trimesh]:
    """Return flat leaves that are turned in all directions, near the camera."""
    parts = []
    for _ in range(_LEAVES):
        distance_m = rng.uniform(*_LEAVES_M)
        leaf = trimesh.creation.cylinder(radius=1.0, height=0.01, sections=24)
        leaf.apply_scale([0.05, 0.022, 0.022])
        turn = trimesh.transformations.euler_matrix(*rng.uniform(-0.7, 0.7, 2), rng.uniform(0, 6.3))
        leaf.apply_transform(turn)
        leaf.apply_translation([rng.normal(0, 0.12), rng.normal(0, 0.06), -distance_m])
        parts.append(colored(leaf, np.array([0.06, rng.uniform(0.2, 0.35), 0.04])))
    return parts


def write_scene(path: Path, parts: list[trimesh.Trimesh]) -> None:
    """Write meshes with a 50 mm camera at the origin that looks along -z."""
    scene = trimesh.Scene(parts)
    scene.camera = trimesh.scene.Camera(name="camera", resolution=SIZE, fov=(39.6, 22.9))
    scene.camera_transform = np.eye(4)
    path.write_bytes(scene.export(file_type="glb"))


def heatlens(*words: object) -> str:
    """Run a command of heatlens; return what it prints."""
    command = [sys.executable, "-m", "heatlens", *map(str, words)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def render(plate: Path, kind: str, behind: tuple[Path, ...], truth: Path) -> float:
    """Write assets/behind_KIND.png; return the FLIP of the whole picture to the truth."""
    words = ("--quality", "final", "--quiet", *LENS, *(("--behind", *behind) if behind else ()))
    exr, png = (plate.with_name(f"{kind}.{ending}") for ending in ("exr", "png"))
    for file in (exr, png):
        heatlens("render", plate, "-o", file, *words)
    path = ASSETS / f"behind_{kind}.png"
    Image.open(png).crop(CROP).save(path, optimize=True)
    return float(json.loads(heatlens("compare", exr, truth, "--json"))["flip"])


def main() -> None:
    """Write assets/behind_guessed.png and assets/behind_known.png, and print their errors."""
    with tempfile.TemporaryDirectory() as name:
        folder, rng = Path(name), np.random.default_rng(5)
        size = ("--size", f"{SIZE[0]}x{SIZE[1]}", "--quiet")
        books = shelf(rng)
        plates = []
        for scene, meshes in (("books", books), ("leaves", books + leaves(rng))):
            write_scene(folder / f"{scene}.glb", meshes)
            out = folder / f"{scene}.####.exr"
            pinhole = ("--pinhole", "--overscan", OVERSCAN_PX, *size)
            heatlens("export", folder / f"{scene}.glb", "-o", out, *pinhole)
            plates += folder.glob(f"{scene}.*.exr")
        clean, plate = plates
        truth = folder / "truth.exr"
        views = ("--method", "accumulation", "--views", VIEWS, *LENS, *size)
        heatlens("render", folder / "leaves.glb", "-o", truth, *views)
        print("guessed", render(plate, "guessed", (), truth))
        print("known", render(plate, "known", (clean,), truth))


if __name__ == "__main__":
    main()
