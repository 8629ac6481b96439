"""Test that images and movies are opened only by the reader of their suffix, in one module."""

import ast
import importlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import av
import numpy as np
import OpenImageIO
import pytest
from PIL import Image

import heatlens
from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.deliver.export.finished import fingerprint_in
from heatlens.fronts.commands.main import main
from heatlens.media.files.picture_formats import suffixes_read
from heatlens.media.plate.picture.picture_open import open_picture
from heatlens.media.plate.read import read_plate
from support.patience import PATIENCE_S

APP = Path(heatlens.__file__).parent
HOME = APP / "media" / "files" / "opened_by_ending.py"
WINDOWS = APP / "core/base/windows_calls.py"
# What opens a picture or a movie by its content.
OPENERS = (
    Image.open,
    av.open,
    OpenImageIO.ImageInput.open,
    OpenImageIO.ImageInput.create,
    OpenImageIO.ImageBuf,
)
LIBRARIES = (av, OpenImageIO)
# Calls of other libraries, or that write.
OTHERS = {
    (
        "deliver/export/movie.py",
        "library.open(str(temporary_path), 'w', format=codec.container, options=options)",
    ),
    (
        "media/scene/gltf/compressed.py",
        "library.open(data)",
    ),  # Basis Universal, in a reading process
}


def local_library_names(tree: ast.AST, names: dict[str, object]) -> dict[str, object]:
    """Return `names` and the local names of a source file that stand for an imported library."""
    found = dict(names)
    for node in ast.walk(tree):
        if isinstance(node, ast.arg) and "ModuleType" in ast.unparse(node.annotation or node):
            found[node.arg] = LIBRARIES
        if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(node.value, ast.Call):
            called = names.get(ast.unparse(node.value.func))
            if getattr(called, "__annotations__", {}).get("return") is ModuleType or called in (
                importlib.import_module,
            ):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                found |= {ast.unparse(target): LIBRARIES for target in targets}
    return found


def possible_values(node: ast.AST, names: dict[str, object]) -> tuple[object, ...]:
    """Return what an expression of names and attributes stands for, in every way that it may."""
    text = ast.unparse(node)
    if text in names:
        found = names[text]
        return found if isinstance(found, tuple) else (found,)
    if isinstance(node, ast.Call) and ast.unparse(node.func) in names:
        called = names[ast.unparse(node.func)]
        is_library = getattr(called, "__annotations__", {}).get("return") is ModuleType
        return LIBRARIES if is_library else ()
    if isinstance(node, ast.Attribute):
        owners = possible_values(node.value, names)
        return tuple(getattr(it, node.attr) for it in owners if hasattr(it, node.attr))
    return ()


def opening_calls(source: str, names: dict[str, object]) -> Iterator[str]:
    """Yield the calls in a source file that reach a library's own opening function."""
    tree = ast.parse(source)
    names = local_library_names(tree, names)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and any(
            value is opener for value in possible_values(node.func, names) for opener in OPENERS
        ):
            yield ast.unparse(node)


def test_only_one_module_opens_images_and_movies():
    calls = set()
    for path in sorted(APP.rglob("*.py")):
        if path == HOME or path.name == "__main__.py":
            continue
        name = ".".join(("heatlens", *path.relative_to(APP).with_suffix("").parts))
        # a module for Windows alone is judged by what it imports, because it cannot be loaded here
        names = (
            {} if path == WINDOWS else vars(importlib.import_module(name.removesuffix(".__init__")))
        )
        for call in opening_calls(path.read_text("utf-8"), names):
            calls.add((path.relative_to(APP).as_posix(), call))
    assert calls == OTHERS


@pytest.mark.parametrize(
    "source",
    [
        "from PIL import Image as Picture\nPicture.open(x)",
        "from PIL.Image import open as look\nlook(x)",
        "import PIL.Image\nPIL.Image.open(x)",
        "from heatlens.media.files.movie_read import av\nav().open(x)",
        "from heatlens.media.files.movie_read import av\nlibrary = av()\nlibrary.open(x)",
        "from types import ModuleType\ndef f(it: ModuleType):\n    it.ImageInput.open(x)",
        "import importlib\nit = importlib.import_module(n)\nit.ImageBuf(x)",
    ],
)
def test_opening_calls_finds_functions_under_any_name(source):
    names: dict[str, object] = {"x": None, "n": None}
    for node in ast.parse(source).body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            exec(ast.unparse(node), names)
    names["importlib.import_module"] = importlib.import_module
    assert list(opening_calls(source, names))


POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n%%EndComments\n{} loop\n"


@pytest.fixture
def ghost(tmp_path, monkeypatch) -> Path:
    """Put a stand-in for Ghostscript in the path; return the file that it makes when it runs."""
    proof, tool = tmp_path / "ghostscript_ran", tmp_path / "bin" / "gs"
    tool.parent.mkdir()
    tool.write_text(f"#!/bin/sh\ntouch {proof}\n")
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tool.parent}{os.pathsep}{os.environ['PATH']}")
    return proof


@pytest.mark.parametrize("suffix", [it for it in suffixes_read()[1:] if it != ".npy"])
def test_postscript_is_not_run_under_any_suffix(tmp_path, ghost, suffix):
    path = tmp_path / f"plate{suffix}"
    path.write_bytes(POSTSCRIPT)
    with pytest.raises(InputError, match=path.name):
        open_picture(path)
    with pytest.raises(InputError, match=path.name):
        read_plate(path, PlateOptions(depth_source=str(path)))
    assert not ghost.exists()


def test_postscript_inside_photo_depth_map_is_not_run(tmp_path, ghost, capsys):
    import base64

    path = tmp_path / "photo.jpg"
    xmp = (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-'
        'syntax-ns#"><rdf:Description xmlns:GDepth="http://ns.google.com/photos/1.0/depthmap/" '
        'GDepth:Format="RangeInverse" GDepth:Near="1" GDepth:Far="9" GDepth:Mime="image/png" '
        f'GDepth:Data="{base64.b64encode(POSTSCRIPT).decode()}"/></rdf:RDF></x:xmpmeta>'
    )
    Image.new("RGB", (8, 8)).save(path, xmp=xmp.encode())
    assert main(["info", str(path)]) in (0, 2)
    assert not ghost.exists() and "fault" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "suffix", "format_name"),
    [
        ("JPEG", ".png", "rename it to p.jpg"),
        ("PNG", ".jpg", "rename it to p.png"),
        ("GIF", ".png", "convert it"),
        ("TIFF", ".bmp", "rename it to p.tif"),
    ],
)
def test_open_picture_names_correct_suffix_of_wrongly_named_file(
    tmp_path, content, suffix, format_name
):
    path = tmp_path / f"p{suffix}"
    Image.new("RGB", (4, 4)).save(path, format=content)
    with pytest.raises(InputError, match=rf"p\{suffix} is {content}, although .*{format_name}"):
        open_picture(path)


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg"])
def test_open_picture_reads_photo_with_second_image_as_jpeg(tmp_path, suffix):
    path, other = tmp_path / f"p{suffix}", Image.new("RGB", (4, 4), (9, 9, 9))
    Image.new("RGB", (4, 4)).save(path, format="MPO", save_all=True, append_images=[other])
    assert open_picture(path).values.shape == (4, 4, 3)


def test_open_picture_reads_float_tiff(tmp_path):
    path, values = tmp_path / "p.tif", np.full((3, 4, 3), 1.5, np.float32)
    out = OpenImageIO.ImageOutput.create(str(path))
    out.open(str(path), OpenImageIO.ImageSpec(4, 3, 3, "float"))
    out.write_image(values)
    out.close()
    np.testing.assert_array_equal(open_picture(path).values, values)


def test_fingerprint_of_playlist_named_as_movie_opens_nothing(tmp_path):
    """The playlist names a pipe, and reading that would never end."""
    pipe = tmp_path / "seg.ts"
    os.mkfifo(pipe)
    movie = tmp_path / "o.mp4"
    movie.write_bytes(b"ffconcat version 1.0\nfile seg.ts\n")
    answer: list[str | None] = []
    asking = threading.Thread(target=lambda: answer.append(fingerprint_in(movie)), daemon=True)
    asking.start()
    asking.join(PATIENCE_S)
    assert answer == [None]
