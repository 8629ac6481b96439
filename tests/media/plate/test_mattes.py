"""Test mattes of objects: their coverage of each pixel and their distance."""

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
from heatlens.media.plate.mark_distance import mark_distances_m, mark_on_plate_m
from heatlens.media.plate.mattes.cryptomatte import hash_name, view_as_ids
from heatlens.media.plate.mattes.mattes import (
    UnknownThingError,
    distance_by_matte_m,
    has_things,
    read_matte,
    thing_at,
    thing_distance_m,
)
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, write_file
from support.mattes import CARD, HEIGHT, HERO, WIDTH, as_float, matte_plate

MIDDLE, NEAREST = MattePart
DEEP = "[" * 9999


def test_hashed_name_is_id_of_cryptomatte():
    assert (hash_name("hero"), hash_name("card")) == (HERO, CARD)


@given(st.text())
def test_hashed_id_is_a_normal_float(name):
    number = as_float(hash_name(name))
    assert np.isfinite(number) and abs(number) >= np.finfo(np.float32).tiny
    assert int(view_as_ids(np.array([number], "f4"))[0]) == hash_name(name)


@pytest.mark.parametrize("name", ["cryptomatte:hero", "crypto:hero", "Crypto:#82ce30b4"])
def test_read_matte_finds_object_by_any_form_of_its_name(tmp_path, name):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0, coverage=0.75))
    hero, card = read_matte(plate, name), read_matte(plate, "cryptomatte:card")
    assert hero.sum() == pytest.approx(0.75 * 64)
    is_hero = hero > 0
    assert np.array_equal(np.argwhere(is_hero).min(axis=0), (8, 12)) and is_hero.sum() == 64
    # The shares of all things of a pixel are never more than the whole pixel.
    assert (hero + card).max() <= 1.0 and card[8:16, 16:20] == pytest.approx(0.25)


def test_read_matte_accepts_object_ids_and_plain_mattes(tmp_path):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0))
    hero = read_matte(plate, "cryptomatte:hero")
    assert np.array_equal(read_matte(plate, "objectId:7"), hero)
    assert np.array_equal(read_matte(plate, "OBJECTID:7"), hero)
    assert read_matte(plate, "matte:mask.A") == pytest.approx(hero / 2)
    with pytest.raises(UnknownThingError, match="has: 0, 7"):
        read_matte(plate, "objectId:8")


def test_cryptomatte_manifest_is_read_only_from_folder_of_file(tmp_path):
    (tmp_path / "names.json").write_text(json.dumps({"the hero": f"{HERO:08x}"}))
    for named in ("names.json", "../elsewhere/names.json", "C:\\x\\names.json"):
        path = matte_plate(tmp_path / "p.exr", 3.0, manifest="", manif_file=named)
        assert read_matte(read_plate(path), "cryptomatte:the hero").sum() == 64


NO_IDS = ('{"hero": 3.5}', '{"hero": "xyz"}', '{"hero": "123456789abcdef"}', '{"hero": "-1"}')


@pytest.mark.parametrize("manifest", ["", "{", "[]", DEEP, *NO_IDS])
def test_read_matte_hashes_name_without_readable_manifest(tmp_path, manifest):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0, manifest=manifest))
    assert read_matte(plate, "cryptomatte:hero").sum() == 64
    assert thing_at(plate, 14, 10) == "Crypto:#82ce30b4"
    with pytest.raises(UnknownThingError, match=r"p\.exr: 'nobody' .*manifest"):
        read_matte(plate, "cryptomatte:nobody")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cryptomatte:heroo", "mean hero"),
        ("cryptomatte:zzz", "hero, card"),
        ("CryptoAsset:hero", "It has: Crypto"),
        ("nothing:7", "'nothing'"),
        ("matte:nothing", "'nothing'"),
        ("Crypto:#xyz", "hexadecimal"),
        ("cryptomatte:h\udcff", "cannot be the name of a thing"),
        ("cryptomatte:\ud800", "cannot be the name of a thing"),
    ],
)
def test_read_matte_of_unknown_name_lists_existing_objects(tmp_path, name, words):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0))
    with pytest.raises(InputError, match=words):
        read_matte(plate, name)


def test_read_matte_of_file_without_mattes_explains_how_to_get_some(tmp_path):
    plate = read_plate(write_file(tmp_path / "q.exr", rgb() | {"Z": np.full((6, 8), 3, "f4")}))
    assert not has_things(plate) and thing_at(plate, 2, 2) is None
    with pytest.raises(UnknownThingError, match=r"q\.exr has no Cryptomatte"):
        read_matte(plate, "cryptomatte:hero")


def test_thing_at_returns_object_with_most_coverage(tmp_path):
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.0, coverage=0.75))
    assert has_things(plate)
    assert thing_at(plate, 14, 10) == "Crypto:hero" and thing_at(plate, 25, 2) == "Crypto:card"
    assert thing_at(plate, 2, 2) is None and thing_at(plate, 99, 2) is None
    assert read_matte(plate, "Crypto:hero")[10, 14] == 0.75


def test_mark_on_object_has_its_depth_and_is_none_if_hidden(tmp_path):
    hero = "cryptomatte:hero"
    plate = read_plate(matte_plate(tmp_path / "p.exr", 3.25))
    assert thing_distance_m(plate, hero, MIDDLE) == pytest.approx(3.25, rel=1e-6)
    hidden = read_plate(matte_plate(tmp_path / "h.exr", None))
    assert thing_distance_m(hidden, hero, MIDDLE) is None
    marks = (
        MatteMark("A", hero),
        DistanceMark("B", 2.0),
        PointMark("C", 25, 2),
        ObjectMark("D", "x"),
    )
    distances_m = [mark_on_plate_m(plate, mark) for mark in marks]
    assert distances_m == pytest.approx([3.25, 2.0, 6.0, None])


def test_mark_over_plates_raises_only_if_no_frame_names_the_object(tmp_path):
    known = read_plate(matte_plate(tmp_path / "k.exr", 3.0))
    other = read_plate(
        matte_plate(tmp_path / "o.exr", None, manifest=json.dumps({"card": f"{CARD:08x}"}))
    )
    mark = MatteMark("A", "cryptomatte:hero")
    assert mark_distances_m([(1, other), (2, known)], mark) == {1: None, 2: pytest.approx(3.0)}
    with pytest.raises(UnknownThingError, match=r"o\.exr"):
        mark_distances_m([(1, other), (2, other)], mark)


DEPTHS = arrays(np.float32, (HEIGHT, WIDTH), elements=st.floats(0.5, 100, width=32))


@given(DEPTHS, st.sampled_from(MattePart), st.floats(0.1, 10))
def test_distance_of_matte_lies_within_it_and_scales_with_depth(depth_m, part, scale):
    matte = np.zeros((HEIGHT, WIDTH), np.float32)
    matte[3:9, 5:12] = 0.75
    matte_m = distance_by_matte_m(matte, depth_m, part)
    inside = depth_m[3:9, 5:12]
    assert (
        matte_m is not None
        and inside.min() <= matte_m * (1 + 1e-6)
        and matte_m <= inside.max() * (1 + 1e-6)
    )
    scaled = distance_by_matte_m(matte, depth_m * np.float32(scale), part)
    assert scaled == pytest.approx(scale * matte_m, rel=1e-5)
    # What is outside the matte does not matter.
    depth_inside_only = np.where(matte > 0, depth_m, np.float32(0.01))
    assert distance_by_matte_m(matte, depth_inside_only, part) == matte_m


def test_distance_of_matte_ignores_edges_and_stray_pixels():
    depth_m, matte = np.full((20, 20), 4, "f4"), np.zeros((20, 20), "f4")
    matte[5:15, 5:15] = 1
    matte[4, 5:15], depth_m[4, 5:15] = 0.4, 50  # the depth of an edge is that of the wall
    depth_m[7, 7] = 0.1
    assert (
        distance_by_matte_m(matte, depth_m, MIDDLE)
        == distance_by_matte_m(matte, depth_m, NEAREST)
        == 4
    )
    depth_m[5:8, 5:15] = 2
    assert (
        distance_by_matte_m(matte, depth_m, NEAREST) == 2
        and distance_by_matte_m(matte, depth_m, MIDDLE) == 4
    )
    assert distance_by_matte_m(np.where(matte > 0, 0.03, 0.0).astype("f4"), depth_m, MIDDLE) is None
    assert distance_by_matte_m(matte, np.full((20, 20), np.inf, "f4"), MIDDLE) == float("inf")
