"""Rehearsal: the quickest preview is rendered once, unseen, before the first drag needs it."""

from typing import Any, cast

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.render.gpu.known_programs import NewProgramError
from heatlens.render.preview.level_choice import useful_levels
from heatlens.studio.session.pictures.elsewhere import ProcessBuilder
from heatlens.studio.session.pictures.live_picture import LivePicture
from heatlens.studio.session.pictures.rehearsal import Rehearsal
from support.fake_renderer import FakeRenderer
from support.plates import plate_of

SIZE = 1280, 720
SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0))
QUICKEST = useful_levels(DefocusSettings(), SIZE)[-1]


class Builder(ProcessBuilder):
    """Builds nothing, and counts who asks for it."""

    def __init__(self) -> None:
        self.requests: list[Shot] = []

    def request(self, shot: Shot, frame: int) -> None:
        self.requests.append(shot)


class RefusingRenderer(FakeRenderer):
    """A renderer that needs new programs for previews while `refuses` is True."""

    refuses = False

    def steps(self, shot: Shot, frame: int, slot: int, enlarges: bool = False):
        if self.refuses and enlarges:
            raise NewProgramError("blur")
        return (yield from super().steps(shot, frame, slot, enlarges))


@pytest.fixture
def renderer() -> RefusingRenderer:
    renderer = RefusingRenderer()
    height, width = SIZE[::-1]
    renderer.load(plate_of(np.zeros((height, width, 3), np.float32), np.ones((height, width))))
    return renderer


@pytest.fixture
def live(renderer) -> LivePicture:
    """A live picture that shows the whole picture of `SHOT`."""
    live = LivePicture(cast(Any, renderer), builder=Builder())
    live.cost.learn(SHOT.defocus, SIZE[0] * SIZE[1], 0.001)
    live.request(SHOT, 0, budget_s=1.0)
    assert live.output is not None and live.output.is_whole
    return live


def rehearse(rehearsal: Rehearsal) -> None:
    for _ in range(100):
        if not rehearsal.is_due:
            return
        rehearsal.work(0.0001)
    raise AssertionError("The rehearsal never ended.")


def test_quickest_level_is_rendered_once_and_not_shown(renderer, live):
    shown, rehearsal = live.output, Rehearsal(cast(Any, renderer), live)
    rehearse(rehearsal)
    assert live.output is shown and live.cost.has_timed(QUICKEST)
    assert [shot.defocus for shot, _ in renderer.rendered] == [SHOT.defocus, QUICKEST]


def test_picture_of_the_user_makes_an_unfinished_rehearsal_start_again(renderer, live):
    rehearsal = Rehearsal(cast(Any, renderer), live)
    rehearsal.work(0.0)
    live.request(Shot(Lens(50.0, 2.0, 4.0, 36.0)), 0, budget_s=1.0)
    rehearse(rehearsal)
    assert [shot.lens.focus_distance_m for shot, _ in renderer.rendered] == [3.0, 4.0, 4.0]


def test_new_program_is_left_to_the_builder_until_it_has_news(renderer, live):
    rehearsal, renderer.refuses = Rehearsal(cast(Any, renderer), live), True
    rehearsal.work(1.0)
    assert not rehearsal.is_due and len(live.builder.requests) == 1
    live.builder.version += 1
    renderer.refuses = False
    rehearse(rehearsal)
    assert live.cost.has_timed(QUICKEST)
