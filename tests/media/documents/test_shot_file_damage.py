"""Test that a damaged shot file reads as another shot or raises an input error."""

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import read_shot
from support.shot_files import FULL, refusal, write_shot_in


def read_or_refuse(path: Path, content: bytes) -> None:
    """Read a shot file; any content must give a shot or an InputError."""
    path.write_bytes(content)
    try:
        assert isinstance(read_shot(path), Shot)
    except InputError as error:
        assert str(path) in str(error)


def test_read_shot_rejects_every_truncation(tmp_path):
    path = write_shot_in(FULL, tmp_path)
    content = path.read_bytes().rstrip()
    for length in range(len(content)):
        assert refusal(path, content[:length])


@pytest.fixture(scope="module")
def whole_file(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return the content of a shot file in which every field is written."""
    return write_shot_in(FULL, tmp_path_factory.mktemp("whole")).read_bytes()


@given(st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
def test_read_shot_of_flipped_byte_gives_shot_or_input_error(tmp_path, whole_file, data):
    content = bytearray(whole_file)
    content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    read_or_refuse(tmp_path / "s.heatlens.json", bytes(content))


ANY_JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=5)
    | st.sampled_from(["inf", "bezier", 10**400, -1, 1e308]),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)


def paths_in_json(value, path=()):
    """Yield the path of keys and indices to each value inside a JSON value."""
    yield path
    if not isinstance(value, dict | list):
        return
    for name, entry in value.items() if isinstance(value, dict) else enumerate(value):
        yield from paths_in_json(entry, (*path, name))


@given(st.data(), ANY_JSON)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
def test_read_shot_of_any_changed_value_gives_shot_or_input_error(
    tmp_path, whole_file, data, value
):
    top = {"": json.loads(whole_file)}
    *path, last_key = data.draw(st.sampled_from(list(paths_in_json(top))[1:]))
    parent = top
    for name in path:
        parent = parent[name]
    parent[last_key] = value
    read_or_refuse(tmp_path / "s.heatlens.json", json.dumps(top[""]).encode())
