"""Mattes of things: who covers which share of a pixel, and how far away they are."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.marks import (
    DistanceMark,
    MatteMark,
    MattePart,
    ObjectMark,
    PointMark,
)
from heatlens.media.plate.mark_distance import mark_on_plate_m, mark_over_plates_m
from heatlens.media.plate.mattes.cryptomatte import bits_of, hashed
from heatlens.media.plate.mattes.mattes import (
    UnknownThingError,
    distance_m,
    has_things,
    matte_of,
    thing_at,
    thing_m,
)
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, write_file
from support.mattes import CARD, HEIGHT, HERO, WIDTH, as_float, matte_plate

MIDDLE, NEAREST = MattePart
DEEP = "[" * 9999


def test_the_hash_of_a_name_is_the_id_that_renderers_write():
    assert (hashed("hero"), hashed("card")) == (HERO, CARD)


@given(st.text())
def test_an_id_is_an_ordinary_float(name):
    number = as_float(hashed(name))
    assert np.isfinite(number) and abs(number) >= np.finfo(np.float32).tiny
    assert int(bits_of(np.array([number], "f4"))[0]) == hashed(name)


@pytest.mark.parametrize("name", ["cryptomatte:hero", "crypto:hero", "Crypto:#82ce30b4"])
def test_a_thing_is_found_by_its_name_in_every_way(tmp_path, name):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0, coverage=0.75))
    hero, card = matte_of(plate, name), matte_of(plate, "cryptomatte:card")
    assert hero.sum() == pytest.approx(0.75 * 64)
    is_hero = hero > 0
    assert np.array_equal(np.argwhere(is_hero).min(axis=0), (8, 12)) and is_hero.sum() == 64
    # The shares of all things of a pixel are never more than the whole pixel.
    assert (hero + card).max() <= 1.0 and card[8:16, 16:20] == pytest.approx(0.25)


def test_ids_and_plain_mattes_are_mattes_too(tmp_path):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0))
    hero = matte_of(plate, "cryptomatte:hero")
    assert np.array_equal(matte_of(plate, "objectId:7"), hero)
    assert np.array_equal(matte_of(plate, "OBJECTID:7"), hero)
    assert matte_of(plate, "matte:mask.A") == pytest.approx(hero / 2)
    with pytest.raises(UnknownThingError, match="has: 0, 7"):
        matte_of(plate, "objectId:8")


def test_a_manifest_may_lie_beside_the_file_but_nowhere_else(tmp_path):
    (tmp_path / "names.json").write_text(json.dumps({"the hero": f"{HERO:08x}"}))
    for named in ("names.json", "../elsewhere/names.json", "C:\\x\\names.json"):
        path = matte_plate(tmp_path / "p.exr", 3.0, manifest="", manif_file=named)
        assert matte_of(read_plate(path), "cryptomatte:the hero").sum() == 64


NO_IDS = ('{"hero": 3.5}', '{"hero": "xyz"}', '{"hero": "123456789abcdef"}', '{"hero": "-1"}')


@pytest.mark.parametrize("manifest", ["", "{", "[]", DEEP, *NO_IDS])
def test_without_a_readable_manifest_a_name_is_hashed(tmp_path, manifest):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0, manifest=manifest))
    assert matte_of(plate, "cryptomatte:hero").sum() == 64
    assert thing_at(plate, 14, 10) == "Crypto:#82ce30b4"
    with pytest.raises(UnknownThingError, match=r"p\.exr: 'nobody' .*manifest"):
        matte_of(plate, "cryptomatte:nobody")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cryptomatte:heroo", "mean hero"),
        ("cryptomatte:zzz", "hero, card"),
        ("CryptoAsset:hero", "It has: Crypto"),
        ("nothing:7", "'nothing'"),
        ("matte:nothing", "'nothing'"),
        ("Crypto:#xyz", "hexadecimal"),
        ("cryptomatte:h\udcff", "no name of a thing"),
        ("cryptomatte:\ud800", "no name of a thing"),
    ],
)
def test_what_is_not_there_is_told_with_what_is(tmp_path, name, words):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0))
    with pytest.raises(InputError, match=words):
        matte_of(plate, name)


def test_a_file_without_mattes_says_how_to_get_some(tmp_path):
    plate = read_plate(write_file(tmp_path / "q.exr", rgb() | {"Z": np.full((6, 8), 3, "f4")}))
    assert not has_things(plate) and thing_at(plate, 2, 2) is None
    with pytest.raises(UnknownThingError, match=r"q\.exr has no Cryptomatte"):
        matte_of(plate, "cryptomatte:hero")


def test_the_thing_under_the_pointer_is_the_one_that_covers_most(tmp_path):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0, coverage=0.75))
    assert has_things(plate)
    assert thing_at(plate, 14, 10) == "Crypto:hero" and thing_at(plate, 25, 2) == "Crypto:card"
    assert thing_at(plate, 2, 2) is None and thing_at(plate, 99, 2) is None
    assert matte_of(plate, "Crypto:hero")[10, 14] == 0.75


def test_a_thing_is_as_far_as_its_depth_and_hidden_where_it_is_not_seen(tmp_path):
    hero = "cryptomatte:hero"
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.25))
    assert thing_m(plate, hero, MIDDLE) == pytest.approx(3.25, rel=1e-6)
    hidden = read_plate(matte_plate(tmp_path / "h.exr", None))
    assert thing_m(hidden, hero, MIDDLE) is None
    marks = (
        MatteMark("A", hero),
        DistanceMark("B", 2.0),
        PointMark("C", 25, 2),
        ObjectMark("D", "x"),
    )
    found = [mark_on_plate_m(plate, mark) for mark in marks]
    assert found == pytest.approx([3.25, 2.0, 6.0, None])


def test_a_thing_that_no_frame_names_is_an_error_and_else_hidden(tmp_path):
    known = read_plate(matte_plate(tmp_path / "k.exr", 3.0))
    other = read_plate(
        matte_plate(tmp_path / "o.exr", None, manifest=json.dumps({"card": f"{CARD:08x}"}))
    )
    mark = MatteMark("A", "cryptomatte:hero")
    assert mark_over_plates_m([(1, other), (2, known)], mark) == {1: None, 2: pytest.approx(3.0)}
    with pytest.raises(UnknownThingError, match=r"o\.exr"):
        mark_over_plates_m([(1, other), (2, other)], mark)


DEPTHS = arrays(np.float32, (HEIGHT, WIDTH), elements=st.floats(0.5, 100, width=32))


@given(DEPTHS, st.sampled_from(MattePart), st.floats(0.1, 10))
def test_the_distance_lies_on_the_thing_and_scales_with_it(depth_m, part, scale):
    matte = np.zeros((HEIGHT, WIDTH), np.float32)
    matte[3:9, 5:12] = 0.75
    found = distance_m(matte, depth_m, part)
    inside = depth_m[3:9, 5:12]
    assert (
        found is not None
        and inside.min() <= found * (1 + 1e-6)
        and found <= inside.max() * (1 + 1e-6)
    )
    scaled = distance_m(matte, depth_m * np.float32(scale), part)
    assert scaled == pytest.approx(scale * found, rel=1e-5)
    # What is outside the matte does not matter.
    other = np.where(matte > 0, depth_m, np.float32(0.01))
    assert distance_m(matte, other, part) == found


def test_edges_and_stray_pixels_do_not_decide():
    depth_m, matte = np.full((20, 20), 4, "f4"), np.zeros((20, 20), "f4")
    matte[5:15, 5:15] = 1
    matte[4, 5:15], depth_m[4, 5:15] = 0.4, 50  # the depth of an edge is that of the wall
    depth_m[7, 7] = 0.1
    assert distance_m(matte, depth_m, MIDDLE) == distance_m(matte, depth_m, NEAREST) == 4
    depth_m[5:8, 5:15] = 2
    assert distance_m(matte, depth_m, NEAREST) == 2 and distance_m(matte, depth_m, MIDDLE) == 4
    assert distance_m(np.where(matte > 0, 0.03, 0.0).astype("f4"), depth_m, MIDDLE) is None
    assert distance_m(matte, np.full((20, 20), np.inf, "f4"), MIDDLE) == float("inf")
