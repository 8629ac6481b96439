"""Surfaces that were merged or left out are told once of each source."""

from dataclasses import replace

import numpy as np

from heatlens.session.opened.lost_surfaces import LostSurfaces
from support.plates import plate_of


def test_a_sentence_is_said_once_and_again_for_another_source():
    said: list[str] = []
    lost = LostSurfaces(said.append)
    whole = plate_of(np.zeros((2, 2, 3), np.float32), np.ones((2, 2), np.float32))
    cut = replace(whole, surfaces_lost="Some were left out.")
    for plate in (None, whole, cut, cut, whole, cut):
        lost.look(plate)
    assert said == ["Some were left out."]
    lost.begin(())
    lost.look(cut)
    assert len(said) == 2
    lost.begin(("Some were left out.",))  # has just been said with the other notes
    lost.look(cut)
    assert len(said) == 2
