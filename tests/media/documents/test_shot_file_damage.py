"""A damaged shot file is another shot or a refusal, whatever the damage."""

import json
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import read_shot
from support.shot_files import FULL, refusal, written


def read_or_refuse(path: Path, content: bytes) -> None:
    """Read a shot file; any content must give a shot or an InputError."""
    path.write_bytes(content)
    try:
        assert isinstance(read_shot(path), Shot)
    except InputError as error:
        assert str(path) in str(error)


def test_every_truncation_is_refused(tmp_path):
    path = written(FULL, tmp_path)
    content = path.read_bytes().rstrip()
    for length in range(len(content)):
        assert refusal(path, content[:length])


@given(st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
def test_a_flipped_byte_makes_another_shot_or_a_refusal(tmp_path, data):
    content = bytearray(written(FULL, tmp_path).read_bytes())
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


def places_of(value, place=()):
    """Return the way to every value inside a JSON value."""
    yield place
    if not isinstance(value, dict | list):
        return
    for name, entry in value.items() if isinstance(value, dict) else enumerate(value):
        yield from places_of(entry, (*place, name))


@given(st.data(), ANY_JSON)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
def test_another_value_anywhere_makes_another_shot_or_a_refusal(tmp_path, data, value):
    top = {"": json.loads(written(FULL, tmp_path).read_text("utf-8"))}
    *way, last = data.draw(st.sampled_from(list(places_of(top))[1:]))
    place = top
    for name in way:
        place = place[name]
    place[last] = value
    read_or_refuse(tmp_path / "s.heatlens.json", json.dumps(top[""]).encode())
