"""A kit that is chosen in the window bounds what the hand does next."""

from dataclasses import replace

import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.lens.lens_commands import KitCommands
from heatlens.studio.session.shot.editing import Editing
from support.shared import shared_of


@pytest.fixture
def editing(messages) -> Editing:
    return Editing(Shot(Lens(55.0, 1.2, 0.3, 36.0)), messages.append)


@pytest.fixture
def kits(editing, messages) -> KitCommands:
    return KitCommands(shared_of(editing, messages.append))


def test_choosing_a_kit_mounts_its_nearest_lens_in_one_undo_step(kits, editing, messages):
    before = editing.shot
    kits.choose("modern-primes")
    lens = editing.lens
    assert (lens.focal_length_mm, lens.f_stop, lens.focus_distance_m) == (50.0, 1.7, 0.45)
    assert "50 mm of modern-primes" in messages[-1]
    editing.undo()
    assert editing.shot == before


def test_lens_edit_beyond_the_kit_is_clamped_and_reported(kits, editing, messages):
    kits.choose("modern-primes")
    editing.edit_lens(replace(editing.lens, f_stop=1.0))
    assert editing.lens.f_stop == 1.7
    assert all(word in messages[-1] for word in ("50 mm", "modern-primes", "f/1.7", "f/1."))
    editing.edit_lens(replace(editing.lens, focus_distance_m=0.2))
    assert editing.lens.focus_distance_m == 0.45
    editing.edit_lens(replace(editing.lens, focal_length_mm=70.0))
    assert (editing.lens.focal_length_mm, editing.lens.close_focus_m) == (65.0, 0.6)


def test_mount_takes_another_lens_of_the_kit(kits, editing):
    kits.choose("modern-primes")
    kits.mount(editing.shot.kit.lenses[-1])
    assert editing.lens.focal_length_mm == 135.0
    assert editing.lens.focus_distance_m == 1.3
    assert kits.mounted_lens == editing.shot.kit.lenses[-1]


def test_choosing_no_kit_lifts_its_limits(kits, editing):
    kits.choose("modern-primes")
    kits.choose(None)
    editing.edit_lens(replace(editing.lens, f_stop=1.0))
    assert editing.shot.kit is None and editing.lens.f_stop == 1.0
    assert kits.mounted_lens is None


def test_edit_of_keyed_focus_sets_key_clamped_to_the_kit(kits, editing):
    editing.do(editing.shot.with_key(0, LensParameter.FOCUS_DISTANCE, 2.0))
    kits.choose("modern-primes")
    editing.edit_lens(replace(editing.lens, focus_distance_m=0.1))
    assert editing.shot.curves.focus_distance_m.key_at(0).value == 0.45


def test_kit_unknown_to_this_machine_stays_listed_and_chosen(kits, editing):
    kits.choose("macro")
    foreign = replace(editing.shot.kit, name="foreign")
    editing.do(replace(editing.shot, kit=foreign))
    assert kits.names[0] == "foreign"
    kits.choose("foreign")  # it is not on the shelf, and stays
    assert editing.shot.kit == foreign
