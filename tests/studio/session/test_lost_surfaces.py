"""Surfaces that were merged or left out are told once of each source."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from heatlens.studio.board.session import LostSurfaces
from support.plates import plate_of
from support.shared import shared_of


def test_lost_surfaces_are_reported_once_for_each_source():
    messages: list[str] = []
    source = SimpleNamespace(plate=None)
    lost_surfaces = LostSurfaces(shared_of(None, messages.append, source))
    whole_plate = plate_of(np.zeros((2, 2, 3), np.float32), np.ones((2, 2), np.float32))
    cut_plate = replace(whole_plate, surfaces_lost="Some were left out.")
    for plate in (None, whole_plate, cut_plate, cut_plate, whole_plate, cut_plate):
        source.plate = plate
        lost_surfaces.poll()
    assert messages == ["Some were left out."]
    lost_surfaces.restart(())
    lost_surfaces.poll()
    assert len(messages) == 2
    lost_surfaces.restart(("Some were left out.",))  # has just been said with the other notes
    lost_surfaces.poll()
    assert len(messages) == 2
