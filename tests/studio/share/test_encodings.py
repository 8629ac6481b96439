"""What clients ask for in sizes is kept for few of them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from heatlens.studio.share.connections import giving_way
from heatlens.studio.share.picture import _ENCODED_MOST, Coding, Picture

PIXELS = np.zeros((30, 2048, 4), np.uint8)


@given(st.lists(st.tuples(st.integers(1, 20_000), st.sampled_from([None, 60, 80])), max_size=60))
def test_few_encodings_of_a_picture_are_kept(asked):
    picture = Picture(1, 1, PIXELS[:2, :400], True)
    for width, quality in asked:
        assert picture.coded(Coding(width, quality))
        assert len(picture._encoded) <= _ENCODED_MOST


def test_a_looker_who_asks_for_each_width_gets_few_files():
    picture = Picture(1, 1, PIXELS, True)
    files = {id(picture.coded(Coding(width, None))): width for width in range(2048, 1400, -1)}
    assert len(files) < 8


@given(st.lists(st.sampled_from("abc"), max_size=20), st.sampled_from("abcd"))
def test_a_place_is_freed_only_where_that_is_fairer(addresses, newcomer):
    places = dict(enumerate(addresses))
    freed = giving_way(places, newcomer)
    own = addresses.count(newcomer)
    if freed is None:
        assert all(addresses.count(it) <= own + 1 for it in addresses)
    else:
        assert addresses.count(places[freed]) > own + 1
        assert places[freed] not in addresses[freed + 1 :]
