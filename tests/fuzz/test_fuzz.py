"""A short run of every fuzzer; `--fuzz-minutes 30` makes it a long one."""

import pytest
from formats import FORMATS
from run import Fuzzer, Job, bad_outcomes

SEED = 20060106
FEW = 150  # the same in each run


@pytest.fixture(scope="module")
def fuzzer():
    with Fuzzer() as started_fuzzer:
        yield started_fuzzer


@pytest.mark.parametrize("name", FORMATS)
def test_readers_of_damaged_files_refuse_or_return_finite_values(fuzzer, name, tmp_path, request):
    minutes = request.config.getoption("--fuzz-minutes")
    few, seconds = (None, 60 * minutes) if minutes else (FEW, None)
    counts = fuzzer.counts(Job(name, seed=SEED, seconds=seconds, mutants=few, keep=str(tmp_path)))
    assert counts.total() > 0
    bad = bad_outcomes(name, counts)
    assert not bad, f"{bad} of {counts.total()}; kept: {sorted(p.name for p in tmp_path.iterdir())}"
