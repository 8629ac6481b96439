"""Encoded pictures are kept for few sizes, and places of clients are shared fairly."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from heatlens.studio.share.connections import client_to_replace
from heatlens.studio.share.picture import _MOST_ENCODED, Coding, Picture

PIXELS = np.zeros((30, 2048, 4), np.uint8)


@given(st.lists(st.tuples(st.integers(1, 20_000), st.sampled_from([None, 60, 80])), max_size=60))
def test_picture_keeps_a_limited_number_of_encodings(codings):
    picture = Picture(1, 1, PIXELS[:2, :400], True)
    for width, quality in codings:
        assert picture.encode(Coding(width, quality))
        assert len(picture._encoded) <= _MOST_ENCODED


def test_picture_encodes_few_files_for_many_widths():
    picture = Picture(1, 1, PIXELS, True)
    files = {id(picture.encode(Coding(width, None))): width for width in range(2048, 1400, -1)}
    assert len(files) < 8


@given(st.lists(st.sampled_from("abc"), max_size=20), st.sampled_from("abcd"))
def test_client_to_replace_is_of_an_address_with_two_more_places(addresses, newcomer):
    places = dict(enumerate(addresses))
    freed = client_to_replace(places, newcomer)
    own_count = addresses.count(newcomer)
    if freed is None:
        assert all(addresses.count(it) <= own_count + 1 for it in addresses)
    else:
        assert addresses.count(places[freed]) > own_count + 1
        assert places[freed] not in addresses[freed + 1 :]
