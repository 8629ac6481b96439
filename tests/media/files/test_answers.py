"""Test the answers of a reading process: prints do not disturb them, and they run no code."""

import ast
import importlib
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from PIL import Image

import heatlens
from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import data_dir
from heatlens.core.model.shot.reel import Reel
from heatlens.fronts.commands.main import main
from heatlens.media.files.answers import ALLOWED, AnswerError, pack_answer, unpack_answer
from heatlens.media.files.apart import call_in_process
from support.noisy_readers import WAYS, Noisy, evil, noisy

APP = Path(heatlens.__file__).parent
# What runs a reader in another process.
CALLERS = ("call_in_process", "read_usd_in_process")
READERS = {
    "heatlens.media.camera.usd_read:usd_camera",
    "heatlens.media.documents.edit_file:_read_reel_bounded",
    "heatlens.media.documents.frame_line_file:_read_bounded",
    "heatlens.media.plate.picture.picture_open:open_picture",
    "heatlens.media.plate.picture.picture_open:picture_info",
    "heatlens.media.scene.gltf.read:_bounded_scene",
    "heatlens.media.scene.usd.files:named_by_usd",
    "heatlens.media.scene.usd.read:usd_scene",
}
# What moves in a scene is a value that can be called, which no annotation tells.
MOVING = (
    "media.scene.usd.read",
    "media.scene.gltf.read",
    "media.scene.gltf.lights",
    "media.scene.gltf.deform",
)
LITTLE = b"Unable find slot_id: 7 in mob \x80\x04cposix\nsystem\n" * 4
MUCH = b"x" * 2**20
NOISES = (
    *(("print", LITTLE), ("descriptor", LITTLE), ("C", LITTLE), ("descriptor", MUCH), ("C", MUCH)),
    ("unflushed", LITTLE),  # last, since printing flushes it
)


def called_readers(path: Path) -> Iterator[str]:
    """Yield the readers that a source file runs in another process, as module:name."""
    module = ".".join(("heatlens", *path.relative_to(APP).with_suffix("").parts))
    text = path.read_text("utf-8")
    has_name = any(name in text for name in CALLERS)  # few files, so few are parsed
    for node in ast.walk(ast.parse(text)) if has_name else ():
        name = getattr(getattr(node, "func", None), "id", "")
        if name in CALLERS and module != "heatlens.media.files.usd_library":
            yield f"{module}:{ast.unparse(node.args[0])}"


def collect_classes(kind: Any, classes: set[type]) -> None:
    """Add all classes of heatlens that a value of type `kind` can hold to `found`."""
    for part in get_args(kind):
        collect_classes(part, classes)
    kind = get_origin(kind) or kind
    if not isinstance(kind, type) or not kind.__module__.startswith("heatlens") or kind in classes:
        return
    classes.add(kind)
    for related_kind in (*kind.__subclasses__(), *get_type_hints(kind).values()):
        collect_classes(related_kind, classes)


def object_named(words: str) -> Any:
    module, _, name = words.partition(":")
    return getattr(importlib.import_module(module), name)


def test_readers_in_source_are_the_expected_ones():
    assert {name for path in APP.rglob("*.py") for name in called_readers(path)} == READERS


def test_allowed_classes_include_every_class_of_an_answer():
    classes: set[type] = set()
    for reader in READERS:
        collect_classes(get_type_hints(object_named(reader))["return"], classes)
    for module in MOVING:
        for value in vars(importlib.import_module(f"heatlens.{module}")).values():
            if isinstance(value, type) and "__call__" in vars(value):
                collect_classes(value, classes)
    missing = {kind for kind in classes if kind.__name__ not in ALLOWED.get(kind.__module__, ())}
    assert len(classes) > 30 and not missing


def test_allowed_names_exist_and_ours_are_classes():
    for module, names in ALLOWED.items():
        if module.startswith("heatlens"):
            assert all(isinstance(object_named(f"{module}:{name}"), type) for name in names)


class PickledCall:
    """An object whose pickle calls a given function with given arguments."""

    def __init__(self, call: Any, *pickled: object) -> None:
        self.made = call, pickled

    def __reduce__(self) -> Any:
        return self.made


@pytest.mark.parametrize(
    ("name", "pickled"),
    [
        ("posix:system", ("true",)),
        ("builtins:eval", ("1",)),
        ("builtins:getattr", ("", "join")),
        ("numpy:load", ("a.npy",)),
        ("numpy:fromfile", ("a.npy",)),
        ("heatlens.core.base.paths:read_file_bytes", (Path("a"),)),
        ("heatlens.media.files.apart:call_in_process", (len, "", "")),
        ("heatlens.core.model.shot.reel:replace", (Reel,)),
        ("importlib:import_module", ("os",)),
    ],
)
def test_unpack_answer_rejects_pickle_that_calls_another_function(name, pickled):
    with pytest.raises(AnswerError, match=name.partition(":")[2]):
        unpack_answer(pickle.dumps(PickledCall(object_named(name), *pickled)))


def test_unpack_answer_returns_packed_values():
    values = [np.arange(6.0).reshape(2, 3), np.float32(2), {"a": (1, None, b"x")}]
    unpacked_values = unpack_answer(pack_answer(values))
    np.testing.assert_array_equal(unpacked_values[0], values[0])
    assert unpacked_values[1:] == values[1:]


def test_call_in_process_rejects_answer_that_calls_a_function(tmp_path, tests_importable):
    new_folder = tmp_path / "made"
    with pytest.raises(InputError, match=r"a\.aaf cannot be read: .*mkdir"):
        call_in_process(evil, str(new_folder), "a.aaf")
    assert not new_folder.exists()


@pytest.fixture
def tests_importable(monkeypatch):
    """Let other processes import the support of the tests."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).resolve().parents[2]))


@pytest.fixture
def call(tmp_path, request) -> tuple[str, object]:
    """Return a reader with something to read."""
    reader, picture = request.param, tmp_path / "p.png"
    Image.new("RGB", (4, 3), (1, 2, 3)).save(picture)
    stage = str(Path(__file__).resolve().parents[2] / "fuzz" / "stage.usda")
    pickled: dict[str, object] = {
        "usd_camera": stage,
        "named_by_usd": stage,
        "usd_scene": stage,
        "open_picture": picture,
        "picture_info": picture,
        "_bounded_scene": (data_dir("assets") / "demo.glb", None),
    }
    return reader, pickled[reader.partition(":")[2]]


LOUD = sorted(name for name in READERS if "documents" not in name)


def check_noises_change_no_answer(reader: str, argument: object, *noises: tuple[str, bytes]):
    quiet = call_in_process(object_named(reader), argument, "a file")
    loud = call_in_process(noisy, Noisy(reader, argument, noises), "a file")
    assert pack_answer(loud) == pack_answer(quiet)


@pytest.mark.parametrize("call", LOUD, indirect=True)
def test_call_in_process_returns_same_answer_if_reader_prints_in_every_way(call, tests_importable):
    assert {way for way, _ in NOISES} == WAYS.keys()
    check_noises_change_no_answer(*call, *NOISES)


@pytest.mark.parametrize(
    "call", ["heatlens.media.plate.picture.picture_open:picture_info"], indirect=True
)
@pytest.mark.parametrize("noise", NOISES, ids=lambda noise: f"{noise[0]}-{len(noise[1])}")
def test_call_in_process_returns_same_answer_if_reader_prints(call, noise, tests_importable):
    check_noises_change_no_answer(*call, noise)


def write_aaf(path: Path, mob: str) -> None:
    """Write an AAF edit whose clip names a missing slot, about which the adapter prints a line."""
    aaf2 = pytest.importorskip("aaf2")
    with aaf2.open(str(path), "w") as file:
        master = file.create.MasterMob(mob)
        master.create_empty_sequence_slot(24, media_kind="picture")
        cut = file.create.CompositionMob("cut")
        cut.usage = "Usage_TopLevel"
        clip = file.create.SourceClip(media_kind="picture")
        clip.length = 24
        clip["SourceID"].value = master.mob_id
        clip["SourceMobSlotID"].value = 77
        sequence = file.create.Sequence(media_kind="picture")
        sequence.length = 24
        cut.create_timeline_slot(24).segment = sequence
        file.content.mobs.extend([master, cut])
        sequence.components.append(clip)


@pytest.mark.parametrize("mob", ["sh010_v003", "evil"])
def test_info_of_aaf_ignores_name_of_mob_that_looks_like_a_pickle(tmp_path, capsys, mob):
    """The adapter prints the name; read as a pickle, it would make a folder."""
    new_folder = tmp_path / "made"
    evil_words = "x" * 59 + f"0cposix\nmkdir\n(S'{new_folder}'\ntR."
    write_aaf(tmp_path / "cut.aaf", evil_words if mob == "evil" else mob)
    assert main(["info", str(tmp_path / "cut.aaf")]) in (0, 2)
    assert not new_folder.exists() and "fault" not in capsys.readouterr().err
