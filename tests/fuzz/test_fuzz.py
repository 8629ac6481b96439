"""A short run of every fuzzer; `--fuzz-minutes 30` makes it a long one."""

import pytest
from formats import FORMATS
from run import badly_answered, fuzzed

SEED = 20060106
SHORT_S = 2.0


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_files_are_refused_in_a_sentence_or_read(name, tmp_path, request):
    minutes = request.config.getoption("--fuzz-minutes")
    counts = fuzzed(name, SEED, 60 * minutes if minutes else SHORT_S, keep=tmp_path)
    assert counts.total() > 0
    bad = badly_answered(name, counts)
    assert not bad, f"{bad} of {counts.total()}; kept: {sorted(p.name for p in tmp_path.iterdir())}"
