"""Who may do what: tokens, addresses, hands."""

import stat

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.studio.share.address import (
    DEFAULT_PORT,
    Address,
    Role,
    kept_links,
    new_links,
    parse_share_address,
)
from heatlens.studio.share.shared import REST_S, WINDOW, Hands


def test_each_token_has_its_role_and_10000_wrong_ones_have_none():
    links = new_links()
    assert links.role_of(links.hand) is Role.HAND and links.role_of(links.look) is Role.LOOK
    wrong = (new_links().hand for _ in range(10_000))
    assert not [token for token in wrong if links.role_of(token) is not None]


@given(st.text(max_size=30))
def test_no_text_is_a_token(text):
    assert new_links().role_of(text) is None


def test_tokens_have_128_bits_and_differ():
    tokens = {token for _ in range(100) for token in vars(new_links()).values()}
    assert len(tokens) == 200 and min(map(len, tokens)) >= 128 / 6


def test_links_are_kept_for_the_user_alone(tmp_path):
    path = tmp_path / "own" / "share.json"
    first = kept_links(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert kept_links(path) == first != kept_links(path, is_new=True)
    path.chmod(0o644)
    now = kept_links(path)
    assert now != first and stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", '{"hand": 1, "look": 2}', '{"hand": "a", "look": "b"}']
)
def test_a_damaged_file_of_links_is_replaced(tmp_path, text):
    path = tmp_path / "share.json"
    path.write_text(text)
    path.chmod(0o600)
    assert kept_links(path) == kept_links(path)


@pytest.mark.parametrize(
    ("text", "host", "port"),
    [
        ("", "127.0.0.1", DEFAULT_PORT),
        ("192.168.1.20", "192.168.1.20", DEFAULT_PORT),
        ("192.168.1.20:9000", "192.168.1.20", 9000),
        (":0", "127.0.0.1", 0),
        ("[::1]:9000", "::1", 9000),
        ("stage.local", "stage.local", DEFAULT_PORT),
    ],
)
def test_addresses(text, host, port):
    assert parse_share_address(text) == Address(host, port)


@pytest.mark.parametrize(
    "text", ["a:b", "1.2.3.4:99999", "http://a", "a/b", "me@a", "0.0.0.0", "[::]:1"]
)
def test_wrong_addresses(text):
    with pytest.raises(InputError, match=r"192\.168\.1\.20"):
        parse_share_address(text)


def test_only_its_own_names_are_meant_for_a_server():
    assert Address().hosts(8870) == {"127.0.0.1:8870", "localhost:8870", "[::1]:8870"}
    assert Address("192.168.1.20").hosts(8870) == {"192.168.1.20:8870"}
    assert "192.168.1.20" in Address("192.168.1.20").hosts(80)


def test_the_last_touch_has_the_lens_once_the_other_rests():
    now = [0.0]
    hands = Hands(lambda: now[0])
    assert hands.take("tablet 1") and hands.holder == "tablet 1"
    now[0] = REST_S - 0.01
    assert not hands.take(WINDOW) and hands.take("tablet 1")
    now[0] += REST_S - 0.01
    assert not hands.take(WINDOW)
    now[0] += 0.02
    assert hands.holder == "" and hands.take(WINDOW) and not hands.take("tablet 1")
