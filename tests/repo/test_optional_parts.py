"""Test the optional parts: each has one record, and a missing package gives one clear message."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import ImageFile

import heatlens
from heatlens.core.base import extras
from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import BASE, EXTRAS, Extra, import_extra, import_module_safely, parts
from heatlens.fronts.commands import info
from heatlens.fronts.commands.main import main
from heatlens.fronts.doctor.machine_check import packages
from heatlens.media.live.ring.opentrackio import Encoding, parse_sample
from heatlens.media.live.ring.receiver import open_ring
from heatlens.media.plate.tracking.crops import import_opencv
from support.command_line import channels
from support.compressed_files import RED_KTX2, draco_square, meshopt_square, square_with_ktx2
from support.exports import write_shot_file
from support.exr_files import write_file
from support.manual import manual_text
from support.mesh_files import STL
from support.networks import write_network
from support.patience import PATIENCE_S
from support.picture_files import save, save_16_bits_of_color

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path(heatlens.__file__).parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LISTED: dict[str, list[str]] = PROJECT["optional-dependencies"]
NO_PARTS = {
    "all": "all other extras of users",
    "desk": "what a desk needs of them",
    "desk-free": "the same without packages under the GPL",
    "fit": "for developers, who make the kernels again",
    "test": "for developers",
}
# Modules that may catch an ImportError, with what they import.
MAY_CATCH = {"core/base/extras.py": "all packages that may be missing"}
MODULES = [module for part in EXTRAS for module in part.packages.values()]
OF_MODULE = {module: part for part in EXTRAS for module in part.packages.values()}


def names_of(requirements: list[str]) -> set[str]:
    """Return the packages of requirements; of heatlens itself, the extras that are named."""
    text = " ".join(re.sub(r"heatlens\[([\w,-]*)\]", r"\1", it) for it in requirements)
    return set(re.sub(r"[<>=]+[\w.]+", "", text).replace(",", " ").split())


def test_extra_records_equal_extras_of_pyproject():
    assert [it.name for it in EXTRAS] == sorted(LISTED.keys() - NO_PARTS)
    for part in EXTRAS:
        assert {*part.packages, *part.brings} == names_of(LISTED[part.name]), part.name
    assert set(BASE.packages) == names_of(PROJECT["dependencies"])


def test_optional_packages_do_not_set_pillow_load_truncated_images():
    for part in parts():
        for module in part.packages.values():
            import_module_safely(module)
    assert "weasyprint" in sys.modules and not ImageFile.LOAD_TRUNCATED_IMAGES


def test_extras_all_desk_and_desk_free_include_their_parts():
    brought = {name for part in EXTRAS for name in part.brings}
    assert names_of(LISTED["all"]) == {it.name for it in EXTRAS} - brought
    assert names_of(LISTED["desk"]) == {"desk-free", "movie"}
    assert names_of(LISTED["desk-free"]) == {"edit", "gui", "ring", "scene", "share", "wgpu"}


def texts(tree: ast.AST) -> list[str]:
    return [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]


_ABOUT_PACKAGES = re.compile(r"ImportError|ModuleNotFoundError|\binstall")


def caught_exceptions(tree: ast.AST) -> set[str]:
    handlers = [it.type for it in ast.walk(tree) if isinstance(it, ast.ExceptHandler) and it.type]
    return {it.id for each in handlers for it in ast.walk(each) if isinstance(it, ast.Name)}


def test_only_extras_module_catches_import_errors():
    installing, catching = set(), set()
    for path in sorted(PACKAGE.rglob("*.py")):
        text, name = path.read_text(encoding="utf-8"), str(path.relative_to(PACKAGE))
        if not _ABOUT_PACKAGES.search(text):  # most files, which need not be parsed
            continue
        tree = ast.parse(text)
        installing |= {name} if any("pip install" in text for text in texts(tree)) else set()
        catching |= (
            {name} if caught_exceptions(tree) & {"ImportError", "ModuleNotFoundError"} else set()
        )
    assert installing == {"core/base/extras.py"}
    assert catching == set(MAY_CATCH)


def test_readme_and_manual_name_existing_extras():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    manual = manual_text()
    list_of_parts = manual.partition("A single part can be named too: ")[2].partition(".")[0]
    assert re.findall(r"`(\w+)`", list_of_parts) == [it.name for it in EXTRAS]
    mentioned_extras = re.findall(r"extra\s+`(\w+)`", readme + manual)
    mentioned_extras += ",".join(re.findall(r"heatlens\[([\w,]+)\]", readme + manual)).split(",")
    assert set(mentioned_extras) <= {it.name for it in EXTRAS}


def plate(folder: Path) -> Path:
    return write_file(folder / "p.exr", channels())


def edit_command(folder: Path, suffix: str) -> list[object]:
    path = folder / f"cut{suffix}"
    path.write_bytes(bytes.fromhex("d0cf11e0a1b11ae1"))  # the head of an AAF
    return ["info", path]


def file_of(name: str, data: bytes = b"nothing") -> Callable[[Path], list[object]]:
    def words(folder: Path) -> list[object]:
        (folder / name).write_bytes(data)
        return ["info", folder / name]

    return words


def compare_command(folder: Path) -> list[object]:
    path = save_16_bits_of_color(folder / "c.png", np.full((16, 16, 3), 7, np.uint16))
    return ["compare", path, path]


def depth_model_command(folder: Path) -> list[object]:
    picture = save(folder / "p.png", np.full((16, 16, 3), 7, np.uint8))
    network = write_network(folder / "n.onnx")
    known = ["--depth-known", "2,2=2m", "--near", "1", "--far", "9"]
    return ["render", picture, "-o", folder / "o.png", "--depth-model", network, *known]


def cluster_command(folder: Path) -> list[object]:
    cluster_option = ["--cluster", "tcp://127.0.0.1:9"]
    return ["export", write_shot_file(folder), "-o", folder / "out" / "n.####.exr", *cluster_option]


def framing_command(folder: Path) -> list[object]:
    (folder / "a.fdl").write_text("{}")
    out = ["-o", folder / "out" / "n.####.png"]
    return ["export", write_shot_file(folder), *out, "--framing", folder / "a.fdl"]


# Words of a command that needs the package of each module.
COMMANDS: dict[str, Callable[[Path], list[object]]] = {
    "distributed": cluster_command,
    "flip_evaluator": lambda folder: ["compare", plate(folder), plate(folder)],
    "opentimelineio": file_of("cut.otio"),
    "otio_aaf_adapter": lambda folder: edit_command(folder, ".aaf"),
    "otio_cmx3600_adapter": lambda folder: edit_command(folder, ".edl"),
    "otio_fcp_adapter": lambda folder: edit_command(folder, ".xml"),
    "onnxruntime": depth_model_command,
    "pillow_heif": file_of("p.heic"),
    "av": file_of("m.mov"),
    "weasyprint": lambda folder: ["shot", "sheet", write_shot_file(folder), "-o", folder / "a.pdf"],
    "OpenImageIO": compare_command,
    "matplotlib": lambda folder: ["bench", "--methods", "--plot", folder / "a.png"],
    "trimesh": file_of("a.stl", STL),
    "charset_normalizer": file_of("a.stl", b"\xff" * 90),
    "DracoPy": lambda folder: ["info", draco_square().write(folder / "a.glb")],
    "meshopt": lambda folder: ["info", meshopt_square().write(folder / "a.glb")],
    "opengl_basisu": lambda folder: ["info", square_with_ktx2(RED_KTX2).write(folder / "a.glb")],
    "pxr": file_of("s.usda", b"#usda 1.0\n"),
    "fdl": framing_command,
}
# Commands of processes of their own, because this process has imported what they need.
APART: dict[str, Callable[[Path], list[object]]] = {
    "glfw": lambda folder: ["view", plate(folder)],
    "imgui_bundle": lambda folder: ["view", plate(folder)],
    "aiohttp": lambda folder: ["serve", plate(folder)],
    "segno": lambda folder: ["serve", plate(folder)],
    "wgpu": lambda folder: ["render", plate(folder), "-o", folder / "o.exr", "--gpu", "wgpu"],
}
# What commands reach only with a camera, a controller or a window.
CALLS: dict[str, Callable[[], object]] = {
    "cbor2": lambda: parse_sample(b"\xa0", Encoding.CBOR),
    "mido": lambda: open_ring("midi:fader"),
    "pythonosc": lambda: open_ring("osc://:9000"),
    "cv2": import_opencv,
}


@pytest.fixture
def remove_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Return a function that makes a package unimportable, here and in started processes."""

    def take(module_name: str) -> None:
        for name in [it for it in sys.modules if it.partition(".")[0] == module_name] + [
            module_name
        ]:
            monkeypatch.setitem(sys.modules, name, None)
        folder = tmp_path / "without"
        folder.mkdir()
        (folder / f"{module_name}.py").write_text(f"raise ImportError('no {module_name}')\n")
        path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
        monkeypatch.setenv("PYTHONPATH", path)

    return take


def check_install_message(message: str, module: str) -> None:
    """Check that the message is one line that tells how to install the package."""
    assert f"{OF_MODULE[module].install_command()}" in message and module in message
    assert len(message.splitlines()) == 1 and message.count("pip install") == 1


def test_every_optional_package_has_a_test_command():
    assert sorted([*COMMANDS, *APART, *CALLS]) == sorted(MODULES)


@pytest.mark.parametrize("module", COMMANDS)
def test_command_without_its_package_names_pip_install(module, tmp_path, capsys, remove_package):
    words = [str(word) for word in COMMANDS[module](tmp_path)]
    remove_package(module)
    assert main(words) == 2
    check_install_message(capsys.readouterr().err, module)


@pytest.mark.parametrize("module", APART)
def test_view_and_serve_without_their_packages_name_pip_install(module, tmp_path, remove_package):
    words = [str(word) for word in APART[module](tmp_path)]
    remove_package(module)
    command = [sys.executable, "-m", "heatlens", *words]
    process = subprocess.run(
        command, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert process.returncode == 2
    check_install_message(process.stderr, module)


@pytest.mark.parametrize("module", CALLS)
def test_function_without_its_package_raises_install_message(module, remove_package):
    remove_package(module)
    with pytest.raises(InputError) as refusal:
        CALLS[module]()
    check_install_message(str(refusal.value), module)


def test_added_extra_record_gives_message_and_doctor_note(tmp_path, capsys, monkeypatch):
    fog = Extra("fog", "A fog", {"fog-maker": "fogmaker"}, besides=", and a cloud")
    monkeypatch.setattr(extras, "EXTRAS", (*EXTRAS, fog))
    monkeypatch.setattr(info, "run", lambda args: import_extra("fogmaker.drops"))
    assert main(["info", str(tmp_path)]) == 2
    assert capsys.readouterr().err == (
        "heatlens: A fog needs the package fog-maker, which cannot be imported (No module named "
        "'fogmaker'). Install it with: pip install 'heatlens[fog]', and a cloud\n"
    )
    (missing,) = (it for it in packages() if it.state == "note")
    assert missing.details == {"missing": "fog-maker"} and fog.install_command() in missing.said
