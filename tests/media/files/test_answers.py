"""What a reading process answers: nothing that is printed reaches it, and it can run nothing."""

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
from heatlens.media.files.answers import ALLOWED, AnswerError, packed, unpacked
from heatlens.media.files.apart import called_apart
from support.noisy_readers import WAYS, Noisy, evil, noisy

APP = Path(heatlens.__file__).parent
READERS = {
    "heatlens.media.camera.usd_read:usd_camera",
    "heatlens.media.documents.edit_file:_bounded_reel",
    "heatlens.media.documents.frame_line_file:_bounded",
    "heatlens.media.plate.picture.picture_open:open_picture",
    "heatlens.media.plate.picture.picture_open:picture_info",
    "heatlens.media.scene.gltf.read:_bounded_scene",
    "heatlens.media.scene.scene_read:named_by_usd",
    "heatlens.media.scene.usd.read:usd_scene",
}
# What moves in a scene is a value that can be called, which no annotation tells.
MOVING = (
    "media.scene.usd.read",
    "media.scene.gltf.read",
    "media.scene.gltf.lights",
    "media.scene.gltf.deform",
)
NOISE = {
    "little": b"Unable find slot_id: 7 in mob \x80\x04cposix\nsystem\n" * 4,
    "much": b"x" * 2**20,
}


def called_in(path: Path) -> Iterator[str]:
    """Yield the readers that a file hands to another process, as module:name."""
    module = ".".join(("heatlens", *path.relative_to(APP).with_suffix("").parts))
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        name = getattr(getattr(node, "func", None), "id", "")
        if (
            name in ("called_apart", "read_usd_apart")
            and module != "heatlens.media.files.usd_library"
        ):
            yield f"{module}:{ast.unparse(node.args[0])}"


def classes_in(kind: Any, found: set[type]) -> None:
    """Add all classes of heatlens that a value of type `kind` can hold to `found`."""
    for part in get_args(kind):
        classes_in(part, found)
    kind = get_origin(kind) or kind
    if not isinstance(kind, type) or not kind.__module__.startswith("heatlens") or kind in found:
        return
    found.add(kind)
    for other in (*kind.__subclasses__(), *get_type_hints(kind).values()):
        classes_in(other, found)


def named(words: str) -> Any:
    module, _, name = words.partition(":")
    return getattr(importlib.import_module(module), name)


def test_the_readers_are_those_of_the_law():
    assert {name for path in APP.rglob("*.py") for name in called_in(path)} == READERS


def test_every_class_of_an_answer_is_in_the_list():
    found: set[type] = set()
    for reader in READERS:
        classes_in(get_type_hints(named(reader))["return"], found)
    for module in MOVING:
        for value in vars(importlib.import_module(f"heatlens.{module}")).values():
            if isinstance(value, type) and "__call__" in vars(value):
                classes_in(value, found)
    missing = {kind for kind in found if kind.__name__ not in ALLOWED.get(kind.__module__, ())}
    assert len(found) > 30 and not missing


def test_the_list_holds_nothing_that_is_gone_and_no_function_of_ours():
    for module, names in ALLOWED.items():
        if module.startswith("heatlens"):
            assert all(isinstance(named(f"{module}:{name}"), type) for name in names)


class Names:
    """A pickle that calls what is named with what is given."""

    def __init__(self, call: Any, *given: object) -> None:
        self.made = call, given

    def __reduce__(self) -> Any:
        return self.made


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("posix:system", ("true",)),
        ("builtins:eval", ("1",)),
        ("builtins:getattr", ("", "join")),
        ("numpy:load", ("a.npy",)),
        ("numpy:fromfile", ("a.npy",)),
        ("heatlens.core.base.paths:file_bytes", (Path("a"),)),
        ("heatlens.media.files.apart:called_apart", (len, "", "")),
        ("heatlens.core.model.shot.reel:replace", (Reel,)),
        ("importlib:import_module", ("os",)),
    ],
)
def test_an_answer_cannot_name_anything_else(name, given):
    with pytest.raises(AnswerError, match=name.partition(":")[2]):
        unpacked(pickle.dumps(Names(named(name), *given)))


def test_values_come_back_as_they_were():
    values = [np.arange(6.0).reshape(2, 3), np.float32(2), {"a": (1, None, b"x")}]
    back = unpacked(packed(values))
    np.testing.assert_array_equal(back[0], values[0])
    assert back[1:] == values[1:]


def test_an_answer_that_names_another_function_is_refused(tmp_path, tests_importable):
    path = tmp_path / "made"
    with pytest.raises(InputError, match=r"a\.aaf cannot be read: .*mkdir"):
        called_apart(evil, str(path), "a.aaf")
    assert not path.exists()


@pytest.fixture
def tests_importable(monkeypatch):
    """Let other processes import the support of the tests."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).resolve().parents[2]))


@pytest.fixture
def asked(tmp_path, request) -> tuple[str, object]:
    """Return a reader with something to read."""
    reader, picture = request.param, tmp_path / "p.png"
    Image.new("RGB", (4, 3), (1, 2, 3)).save(picture)
    stage = str(Path(__file__).resolve().parents[2] / "fuzz" / "stage.usda")
    given: dict[str, object] = {
        "usd_camera": stage,
        "named_by_usd": stage,
        "usd_scene": stage,
        "open_picture": picture,
        "picture_info": picture,
        "_bounded_scene": (data_dir("assets") / "demo.glb", None),
    }
    return reader, given[reader.partition(":")[2]]


LOUD = sorted(name for name in READERS if "documents" not in name)


QUIET: dict[str, bytes] = {}  # the answer of each reader that prints nothing


@pytest.mark.parametrize("asked", LOUD, indirect=True)
@pytest.mark.parametrize(
    ("way", "amount"), [*((way, "little") for way in WAYS), ("descriptor", "much"), ("C", "much")]
)
def test_a_reader_that_prints_gives_the_same_answer(asked, way, amount, tests_importable):
    reader, argument = asked
    if reader not in QUIET:
        QUIET[reader] = packed(called_apart(named(reader), argument, "a file"))
    loud = called_apart(noisy, Noisy(reader, argument, way, NOISE[amount]), "a file")
    assert packed(loud) == QUIET[reader]


def write_aaf(path: Path, mob: str) -> None:
    """Write an edit whose clip names a slot that is not there, of which the adapter tells."""
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
def test_the_name_of_a_mob_is_no_answer(tmp_path, capsys, mob):
    """The adapter prints it; as a pickle, these words would make a folder."""
    made = tmp_path / "made"
    evil_words = "x" * 59 + f"0cposix\nmkdir\n(S'{made}'\ntR."
    write_aaf(tmp_path / "cut.aaf", evil_words if mob == "evil" else mob)
    assert main(["info", str(tmp_path / "cut.aaf")]) in (0, 2)
    assert not made.exists() and "fault" not in capsys.readouterr().err
