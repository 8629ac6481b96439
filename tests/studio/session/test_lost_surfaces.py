"""Surfaces that were merged or left out are told once of each source."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from heatlens.studio.session.session import LostSurfaces
from support.plates import plate_of
from support.shared import shared_of


def test_a_sentence_is_said_once_and_again_for_another_source():
    said: list[str] = []
    source = SimpleNamespace(plate=None)
    lost = LostSurfaces(shared_of(None, said.append, source))
    whole = plate_of(np.zeros((2, 2, 3), np.float32), np.ones((2, 2), np.float32))
    cut = replace(whole, surfaces_lost="Some were left out.")
    for plate in (None, whole, cut, cut, whole, cut):
        source.plate = plate
        lost.poll()
    assert said == ["Some were left out."]
    lost.begin(())
    lost.poll()
    assert len(said) == 2
    lost.begin(("Some were left out.",))  # has just been said with the other notes
    lost.poll()
    assert len(said) == 2
