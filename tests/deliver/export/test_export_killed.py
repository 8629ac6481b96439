"""Test that a killed and resumed export of any kind leaves the files of an undisturbed one.

`python tests/fuzz/kills.py --kills 1000` does so for hours.
"""

import random

import pytest

from fuzz.kills import KINDS, Exports


# A jpg is written as a png is, an mp4 as a mov: the loop of hours above takes them too.
@pytest.mark.parametrize("kind", sorted(set(KINDS) - {"jpg", "mp4"}))
def test_killed_and_resumed_export_gives_same_bytes(kind, tmp_path):
    exports = Exports(tmp_path)
    exports.prepare(kind)
    assert exports.whole[kind]
    outcome = exports.killed_and_resumed(kind, 2, random.Random(f"20060106 {kind}"))
    assert not outcome.faults
