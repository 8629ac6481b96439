"""Test that files are opened for reading in base/paths only: no pipe, no device, with a limit."""

import ast
import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import heatlens
from heatlens.core.base.paths import open_regular_file, read_file_bytes
from heatlens.media.plate.header.channels import Header
from heatlens.media.plate.mattes.cryptomatte import Cryptomatte

APP = Path(heatlens.__file__).parent
GUARD = "core/base/paths.py"
READERS = ("read_text", "read_bytes", "load", "fromfile", "memmap", "loadtxt", "genfromtxt")
_MAY_READ = re.compile(rf"\b(open|{'|'.join(READERS)})\b\)*\s*\(")
# What heatlens brings, writes itself or gets from the system, with a part of the call.
OWN = {
    "_FACTS.read_text",
    "data_dir(",
    "Path('/proc/",
    "Path(f'/proc/",
    "tasks.read_text",
    "_FILE.read_text",
    "_MEMINFO.read_text",
    "_PAGES.read_text",
    "_RIM_FILE.read_text",
    "program_file.read_bytes",  # the program itself, for its fingerprint
    "Path(path).read_text",  # a shader
    "(folder / name).read_bytes",  # the page of the browser
    "page.read_text",  # a page of the manual
    "'icon.svg').read_bytes",  # the icon of the program
    "newest.path.read_bytes",  # a version of a shot that the program has saved itself
    "spooled.read_bytes",  # a temporary file of this process
    "json.load",
    "np.load(BytesIO(",
    "Preferences.load",
}
WRITING = ("'w'", "'wb'", "'rb+'", "'r+b'", "os.dup", "_NEW_FILE", "flags", "os.O_WRONLY")


def file_reads(path: Path) -> Iterator[str]:
    """Yield the calls in a source file that open or read another file by its path."""
    source = path.read_text("utf-8")
    for node in ast.walk(ast.parse(source)) if _MAY_READ.search(source) else ():
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if name not in ("open", *READERS):
            continue
        text = ast.unparse(node)
        is_path = name == "open" and (
            isinstance(node.func, ast.Name)
            or ast.unparse(node.func) in ("os.open", "io.open")
            or any("b'" in repr(ast.unparse(it)) or ast.unparse(it) == "'rb'" for it in node.args)
        )
        if name in READERS and isinstance(node.func, ast.Attribute):
            of_module = ast.unparse(node.func.value)
            if name in READERS[:2] or of_module in ("np", "numpy"):
                yield text
        elif is_path and not any(word in text for word in WRITING):
            yield text


def test_only_base_paths_opens_files_for_reading():
    reads = {
        (path.relative_to(APP).as_posix(), text)
        for path in APP.rglob("*.py")
        if path.relative_to(APP).as_posix() != GUARD
        for text in file_reads(path)
        if not any(word in text for word in OWN)
    }
    assert not reads


@pytest.mark.parametrize(
    "source",
    ["open(p)", "open(p, 'rb')", "p.open('rb')", "p.read_text()", "np.load(p)", "os.open(p, 0)"],
)
def test_file_reads_finds_every_kind_of_call(tmp_path, source):
    path = tmp_path / "a.py"
    path.write_text(source)
    assert list(file_reads(path))


def test_open_regular_file_rejects_pipe_device_and_folder(tmp_path):
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to("/dev/zero")
    for path in (pipe, link, tmp_path):
        with pytest.raises(OSError, match="it is"):
            open_regular_file(path)


def test_read_file_bytes_rejects_file_above_limit(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"x" * 11)
    assert read_file_bytes(path, 11) == b"x" * 11
    with pytest.raises(OSError, match="more than"):
        read_file_bytes(path, 10)


@pytest.mark.parametrize("kind", ["device", "pipe", "large"])
def test_cryptomatte_ignores_manifest_that_is_no_plain_file(tmp_path, kind):
    path = tmp_path / "m.json"
    match kind:
        case "device":
            path.symlink_to("/dev/zero")
        case "pipe":
            os.mkfifo(path)
        case _:
            with path.open("wb") as file:
                file.truncate(65_000_000)
    header: Header = {"manif_file": "m.json"}
    assert Cryptomatte(name="crypto", ranks=(), header=header, folder=tmp_path).ids == {}
