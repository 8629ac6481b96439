"""A short run of every fuzzer; `--fuzz-minutes 30` makes it a long one."""

import pytest
from formats import FORMATS
from run import Fuzzer, Job, badly_answered

SEED = 20060106
FEW = 150  # the same in each run


@pytest.fixture(scope="module")
def fuzzer():
    with Fuzzer() as running:
        yield running


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_files_are_refused_in_a_sentence_or_read(fuzzer, name, tmp_path, request):
    minutes = request.config.getoption("--fuzz-minutes")
    few, seconds = (None, 60 * minutes) if minutes else (FEW, None)
    counts = fuzzer.counts(Job(name, SEED, seconds, few, keep=str(tmp_path)))
    assert counts.total() > 0
    bad = badly_answered(name, counts)
    assert not bad, f"{bad} of {counts.total()}; kept: {sorted(p.name for p in tmp_path.iterdir())}"
