"""An export of any kind that is killed and resumed leaves the files of one that nobody disturbed.

`python tests/fuzz/kills.py --kills 1000` does so for hours.
"""

import random

import pytest

from fuzz.kills import KINDS, Exports


@pytest.mark.parametrize("kind", KINDS)
def test_a_killed_export_goes_on_to_the_same_bytes(kind, tmp_path):
    exports = Exports(tmp_path)
    exports.prepare(kind)
    assert exports.whole[kind]
    outcome = exports.killed_and_resumed(kind, 2, random.Random(f"20060106 {kind}"))
    assert not outcome.faults
