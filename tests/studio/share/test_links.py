"""Access to a shared session: tokens of links, addresses, and who holds the lens."""

import stat

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.studio.share.address import (
    DEFAULT_PORT,
    Address,
    Role,
    load_or_make_links,
    new_links,
    parse_share_address,
)
from heatlens.studio.share.shared import REST_S, WINDOW, Hands


def test_role_of_knows_both_tokens_and_no_other():
    links = new_links()
    assert links.role_of(links.hand) is Role.HAND and links.role_of(links.look) is Role.LOOK
    wrong = (new_links().hand for _ in range(10_000))
    assert not [token for token in wrong if links.role_of(token) is not None]


@given(st.text(max_size=30))
def test_role_of_arbitrary_text_is_none(text):
    assert new_links().role_of(text) is None


def test_new_links_have_distinct_tokens_of_128_bits():
    tokens = {token for _ in range(100) for token in vars(new_links()).values()}
    assert len(tokens) == 200 and min(map(len, tokens)) >= 128 / 6


def test_links_file_is_private_and_replaced_if_readable_by_others(tmp_path):
    path = tmp_path / "own" / "share.json"
    first = load_or_make_links(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert load_or_make_links(path) == first != load_or_make_links(path, is_new=True)
    path.chmod(0o644)
    new_links_of_file = load_or_make_links(path)
    assert new_links_of_file != first and stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", '{"hand": 1, "look": 2}', '{"hand": "a", "look": "b"}']
)
def test_load_or_make_links_replaces_a_damaged_file(tmp_path, text):
    path = tmp_path / "share.json"
    path.write_text(text)
    path.chmod(0o600)
    assert load_or_make_links(path) == load_or_make_links(path)


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
def test_parse_share_address_reads_host_and_port(text, host, port):
    assert parse_share_address(text) == Address(host, port)


@pytest.mark.parametrize(
    "text", ["a:b", "1.2.3.4:99999", "http://a", "a/b", "me@a", "0.0.0.0", "[::]:1"]
)
def test_parse_share_address_refuses_wrong_addresses(text):
    with pytest.raises(InputError, match=r"192\.168\.1\.20"):
        parse_share_address(text)


def test_address_hosts_lists_the_names_of_its_server():
    assert Address().hosts(8870) == {"127.0.0.1:8870", "localhost:8870", "[::1]:8870"}
    assert Address("192.168.1.20").hosts(8870) == {"192.168.1.20:8870"}
    assert "192.168.1.20" in Address("192.168.1.20").hosts(80)


def test_hands_pass_the_lens_on_only_after_the_holder_rests():
    clock_s = [0.0]
    hands = Hands(lambda: clock_s[0])
    assert hands.try_take("tablet 1") and hands.holder == "tablet 1"
    clock_s[0] = REST_S - 0.01
    assert not hands.try_take(WINDOW) and hands.try_take("tablet 1")
    clock_s[0] += REST_S - 0.01
    assert not hands.try_take(WINDOW)
    clock_s[0] += 0.02
    assert hands.holder == "" and hands.try_take(WINDOW) and not hands.try_take("tablet 1")
