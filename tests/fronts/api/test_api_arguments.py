"""Test the arguments of the Python interface: any wrong value raises a clear `HeatlensError`.

Nothing is drawn here: what is tested comes before the first pixel.
"""

import decimal
import fractions
import inspect
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import heatlens
from heatlens.core.base.errors import HeatlensError
from heatlens.fronts.api.arguments import _NAMES
from heatlens.fronts.api.engine import ENGINE
from support.command_line import CAMERA, channels
from support.exr_files import write_file

LENS = {"f_stop": 2.0, "focus_distance_m": 3.0, "focal_length_mm": 50.0}
COLORS, DEPTH_M = np.ones((6, 8, 3), np.float32), np.full((6, 8), 3.0, np.float32)


class PinholeRenderer:
    """A renderer that returns the pinhole picture of the plate unchanged."""

    def load(self, plate) -> None:
        self.loaded = SimpleNamespace(plate=plate)

    def pixels(self, shot, frame) -> np.ndarray:
        return self.loaded.plate.color


@pytest.fixture(scope="module", autouse=True)
def pinhole_engine():
    with pytest.MonkeyPatch.context() as patch:
        renderer = PinholeRenderer()
        patch.setattr(ENGINE, "renderer", lambda: renderer)
        ENGINE._loaded = None
        yield
        ENGINE._loaded = None


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    return write_file(tmp_path_factory.mktemp("api") / "p.exr", channels(), **CAMERA)


SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.sampled_from([10**400, -(10**5000), 2**31, np.int64(3), np.bool_(True), np.str_("2.8")]),
    st.floats(),
    st.sampled_from([np.float32(2.8), np.float64("nan"), np.complex64(1j), np.datetime64("NaT")]),
    st.complex_numbers(),
    st.text(),
    st.sampled_from(
        ["6ft", "f/2.8", "inf", "film", "\0", "\ud800", "demo", "film.exr", "a" * 5000, "~no one/z"]
    ),
    st.binary(),
    st.sampled_from([fractions.Fraction(7, 2), decimal.Decimal("2.8"), Path("x"), object(), len]),
    st.sampled_from([np.array(2.8), np.array([2.8]), np.ones((2, 2)), np.array([]), np.array("a")]),
)
ODD = st.one_of(
    SCALARS,
    st.lists(SCALARS, max_size=3),
    st.tuples(SCALARS, SCALARS),
    st.dictionaries(st.text(max_size=2), SCALARS, max_size=2),
    st.sets(st.integers(), max_size=2),
)
MANY = settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def check_raises_only_heatlens_error(call) -> None:
    """Check that `call` returns or raises a `HeatlensError` with a short message."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", heatlens.HeatlensWarning)
        try:
            call()
        except HeatlensError as error:
            assert str(error) and len(str(error)) < 8000


@MANY
@given(name=st.sampled_from(_NAMES["render"]), value=ODD)
def test_render_with_any_value_raises_only_heatlens_error(name, value):
    source = heatlens.open(COLORS, DEPTH_M)
    check_raises_only_heatlens_error(lambda: source.render(**{**LENS, name: value}))


@MANY
@given(name=st.sampled_from(_NAMES["open"]), value=ODD)
def test_open_with_any_value_raises_only_heatlens_error(plate, name, value):
    check_raises_only_heatlens_error(lambda: heatlens.open(plate, **{name: value}).render(**LENS))
    check_raises_only_heatlens_error(
        lambda: heatlens.open(COLORS, **{"depth_m": DEPTH_M, name: value}).render(**LENS)
    )


@MANY
@given(source=ODD)
def test_open_of_any_source_raises_only_heatlens_error(source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if not (isinstance(source, str) and source == "demo"):  # which takes its time
        check_raises_only_heatlens_error(lambda: heatlens.open(source, DEPTH_M))


def test_argument_hints_know_every_argument():
    signature = inspect.signature(heatlens.Source.render).parameters
    assert {n for n in signature if n not in ("self", "more")} <= set(_NAMES["render"])
    signature = inspect.signature(heatlens.open).parameters
    assert {n for n in signature if n not in ("source", "reading")} <= set(_NAMES["open"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"focus_distance_m": "6ft"}, r"must be a number, got '6ft': write 1\.8288\."),
        ({"f_stop": "2.8"}, r"f_stop must be a number, got '2\.8': write 2\.8\."),
        ({"f_stop": [1, 2]}, r"f_stop must be a number, got \[1, 2\]\."),
        ({"f_stop": True}, "f_stop must be a number, got True"),
        ({"f_stop": 10**400}, "f_stop is too large a number"),
        ({"focus_at": (10.5, 10)}, r"focus_at must be a pixel \(x, y\), two whole numbers"),
        ({"focus_at": 5}, r"focus_at must be a pixel \(x, y\), two whole numbers, got 5"),
        ({"views": 66.5}, "views must be a whole number"),
        ({"lens": 1.4}, r"lens must be a heatlens\.Lens, got 1\.4"),
        ({"aperture_image": 3}, "aperture_image must be a text, got 3"),
        ({"focus_distance": 3}, r"no argument 'focus_distance'. Did you mean focus_distance_m\?"),
        ({"fstop": 3}, r"Did you mean f_stop\?"),
        ({"aperture": 3}, r"Did you mean f_stop\?"),
        ({"scene_unit_m": 0.01}, "in render: it is an argument of open"),
        ({"xyzzy": 3}, "there are lens, frame, focal_length_mm"),
    ],
)
def test_wrong_argument_of_render_raises_error_with_hint(arguments, words):
    source = heatlens.open(COLORS, DEPTH_M)
    default_focus = {} if "focus_at" in arguments else {"focus_distance_m": 3.0}
    with pytest.raises(HeatlensError, match=words):
        source.render(**{"f_stop": 2.0, "focal_length_mm": 50.0, **default_focus, **arguments})


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda p: heatlens.open(3), r"the name of a file, or an array of colours .*, got 3\."),
        (lambda p: heatlens.open(b"p.exr"), r"got b'p.exr'"),
        (lambda p: heatlens.open(p, scene_unit="cm"), r"Did you mean scene_unit_m\?"),
        (lambda p: heatlens.open(p, scene_unit_m="cm"), r"got 'cm': write 0\.01\."),
        (lambda p: heatlens.open(p, scene_unit_m=0), "a number of metres above 0, got 0"),
        (lambda p: heatlens.open(p, strict="no"), "strict must be True or False, got 'no'"),
        (lambda p: heatlens.open(p, depth_kind="flat"), "depth_kind is one of auto, planar"),
        (lambda p: heatlens.open(p, f_stop=2), "in open: it is an argument of render"),
        (
            lambda p: heatlens.open(p).render(frame=99),
            r"p\.exr is a single picture: leave frame out",
        ),
        (lambda p: heatlens.open("demo", size=(64.5, 36)), r"a size \(width, height\)"),
    ],
)
def test_wrong_argument_of_open_raises_error_with_hint(plate, call, words):
    with pytest.raises(HeatlensError, match=words):
        call(plate)


@pytest.mark.parametrize("name", ["a" * 5000, "b" * 300 + ".exr", "~no one/z.exr", "z\0.exr"])
def test_impossible_file_names_raise_heatlens_error(plate, name):
    source = heatlens.open(COLORS, DEPTH_M)
    for call in (
        lambda: heatlens.open(name),
        lambda: heatlens.open(plate, depth_source=name).render(),
        lambda: heatlens.open(plate, behind=name).render(),
        lambda: source.render(**LENS, aperture_image=name),
    ):
        with pytest.raises(
            HeatlensError, match=r"not there|cannot be|neither a file|a name cannot"
        ):
            call()


def test_render_accepts_numpy_numbers():
    source = heatlens.open(COLORS, DEPTH_M)
    arguments = {"f_stop": np.float32(2), "focus_at": np.array([2, 3]), "blades": np.int64(5)}
    source.render(**arguments, focal_length_mm=np.array(50), layers=np.uint8(2))


@pytest.mark.parametrize(
    ("colors", "depth", "words"),
    [
        ((COLORS * 255).astype(np.uint8), DEPTH_M, r"whole numbers \(uint8\).*scene-linear"),
        (COLORS > 0, DEPTH_M, r"whole numbers \(bool\)"),
        (COLORS.astype(complex), DEPTH_M, r"The colours cannot be complex numbers \(complex128\)"),
        (COLORS, DEPTH_M.astype(complex), "depth_m cannot be complex numbers"),
        (COLORS, DEPTH_M.astype(str), "depth_m cannot be read as numbers"),
        (np.ma.masked_less(COLORS, 2), DEPTH_M, r"The colours cannot have masked.*filled\(0\)"),
        (COLORS, np.ma.masked_greater(DEPTH_M, 2), r"depth_m cannot have masked.*numpy\.inf"),
        (COLORS.astype(object), DEPTH_M, "the dtype is object"),
        (COLORS * np.float64(1e300), DEPTH_M, "NaN or infinity"),
        ([[[0.5, 0.5, 0.5], [0.5]]], DEPTH_M, "cannot be read as one array of numbers"),
    ],
)
def test_open_rejects_arrays_of_unsuitable_type(colors, depth, words):
    with pytest.raises(HeatlensError, match=words):
        heatlens.open(colors, depth)


def test_open_accepts_unmasked_masked_arrays_and_integer_depths():
    source = heatlens.open(np.ma.asarray(COLORS), DEPTH_M.astype(np.uint16))
    assert not isinstance(source.render(**LENS), np.ma.MaskedArray)


@pytest.mark.parametrize("shape", [(40000, 40000), (16385, 1), (1, 10**9), (0, 4), (4, 0)])
def test_open_rejects_impossible_array_sizes_without_copy(shape):
    """A copy of the first array would take 22 GB."""
    colors = np.broadcast_to(np.float64(0.5), (*shape, 3))
    depth_m = np.broadcast_to(np.float64(3.0), shape)
    with pytest.raises(
        HeatlensError, match=r"The colours have .* heatlens takes 1 to 16384 a side"
    ):
        heatlens.open(colors, depth_m)
    with pytest.raises(HeatlensError, match=r"The depth has shape"):
        heatlens.open(COLORS, depth_m)
