"""Compare `ByteLru`, which keeps the values used last, with a plain list sorted by use."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.byte_lru import ByteLru

LIMIT = 10
keys = st.integers(0, 4)
sizes = st.integers(0, LIMIT + 3)
gets = keys.map(lambda key: ("get", key))
puts = st.tuples(st.just("put"), keys, sizes)
resizes = sizes.map(lambda limit: ("resize", limit))
actions = st.lists(st.one_of(gets, puts, puts, resizes, st.just(("clear",))), max_size=40)


class ListStore:
    """The rules of `ByteLru` on a plain list of pairs (key, size), the one used last at the end."""

    def __init__(self, keeps_newest: bool) -> None:
        self.pairs: list[tuple[int, int]] = []
        self.keeps_newest = keeps_newest
        self.limit = LIMIT

    def get(self, key: int) -> int | None:
        used = [pair for pair in self.pairs if pair[0] == key]
        self.pairs = [pair for pair in self.pairs if pair[0] != key] + used
        return used[0][1] if used else None

    def put(self, key: int, size: int) -> None:
        self.pairs = [pair for pair in self.pairs if pair[0] != key]
        if size <= self.limit or self.keeps_newest:
            self.pairs.append((key, size))
        self.resize(self.limit)

    def resize(self, limit: int) -> None:
        self.limit = limit
        while self.pairs[self.keeps_newest :] and self.total > limit:
            self.pairs.pop(0)

    def clear(self) -> None:
        self.pairs = []

    @property
    def total(self) -> int:
        return sum(size for _, size in self.pairs)


@given(actions, st.booleans())
def test_byte_lru_agrees_with_list_model_after_any_steps(
    steps: list[tuple[str, int, int]], keeps_newest: bool
) -> None:
    store: ByteLru[int, int] = ByteLru(LIMIT, bytes_of=int, keeps_newest=keeps_newest)
    model = ListStore(keeps_newest)
    for name, *values in steps:
        assert getattr(store, name)(*values) == getattr(model, name)(*values)
        assert store.bytes_in_use == model.total and store.limit_bytes == model.limit
        assert store.keys() == dict(model.pairs).keys()
        assert store.bytes_in_use <= model.limit or len(model.pairs) == keeps_newest
    for key, size in tuple(model.pairs):
        assert store.get(key) == size


@given(st.integers(LIMIT + 1, 3 * LIMIT))
def test_put_of_too_large_value_evicts_nothing(size: int) -> None:
    store: ByteLru[str, int] = ByteLru(LIMIT, bytes_of=int)
    store.put("small", 3)
    store.put("large", size)
    assert store.get("small") == 3 and store.get("large") is None
