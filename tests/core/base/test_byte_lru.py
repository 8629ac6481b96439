"""The store that keeps what was used last, against a list that is sorted by use."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.byte_lru import ByteLru

LIMIT = 10
keys = st.integers(0, 4)
actions = st.lists(st.one_of(keys, st.tuples(keys, st.integers(0, LIMIT + 3))), max_size=40)


class Model:
    """The same rules, said plainly: pairs (key, size), the one used last at the end."""

    def __init__(self, keeps_newest: bool) -> None:
        self.pairs: list[tuple[int, int]] = []
        self.keeps_newest = keeps_newest

    def get(self, key: int) -> int | None:
        used = [pair for pair in self.pairs if pair[0] == key]
        self.pairs = [pair for pair in self.pairs if pair[0] != key] + used
        return used[0][1] if used else None

    def put(self, key: int, size: int) -> None:
        others = [pair for pair in self.pairs if pair[0] != key]
        if size > LIMIT:
            self.pairs = [(key, size)] if self.keeps_newest else others
            return
        while sum(each for _, each in others) + size > LIMIT:
            others.pop(0)
        self.pairs = [*others, (key, size)]


@given(actions, st.booleans())
def test_a_store_keeps_what_a_plain_list_keeps(
    steps: list[int | tuple[int, int]], keeps_newest: bool
) -> None:
    store: ByteLru[int, int] = ByteLru(LIMIT, bytes_of=int, keeps_newest=keeps_newest)
    model = Model(keeps_newest)
    for step in steps:
        if isinstance(step, tuple):
            store.put(*step)
            model.put(*step)
        else:
            assert store.get(step) == model.get(step)
        assert store.bytes_in_use == sum(size for _, size in model.pairs)
    for key, size in tuple(model.pairs):
        assert store.get(key) == size
    assert all(store.get(key) is None for key in set(range(5)) - dict(model.pairs).keys())


@given(st.integers(LIMIT + 1, 3 * LIMIT))
def test_a_value_beyond_the_limit_drops_nothing_that_fits(size: int) -> None:
    store: ByteLru[str, int] = ByteLru(LIMIT, bytes_of=int)
    store.put("small", 3)
    store.put("large", size)
    assert store.get("small") == 3 and store.get("large") is None
