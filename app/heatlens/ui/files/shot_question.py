"""Ask after a crash whether to recover the unsaved changes of a shot."""

from imgui_bundle import imgui

from heatlens.base.printable import printable
from heatlens.session.files.shot_documents import ShotDocuments
from heatlens.session.shot.shot_store import Found
from heatlens.ui import probe, topmost, widgets
from heatlens.ui.files.question import question

_TITLE = "Not saved###unsaved shot"
_WIDTH_EM = 30.0


def shot_question(documents: ShotDocuments) -> None:
    """Draw the question while there are unsaved changes to recover."""
    offer = documents.offer
    if offer is None:
        return
    with question(_TITLE, _WIDTH_EM) as shown:
        if shown:
            _answer(documents, offer)


def _answer(documents: ShotDocuments, offer: Found) -> None:
    topmost.answers_keys_itself()
    if offer.saved is None:
        imgui.text_wrapped("There is a shot of this plate that was never saved to a file.")
    else:
        imgui.text_wrapped(f"{printable(offer.path.name)} was changed after it was saved last.")
    imgui.text_wrapped("Heatlens ended before that was saved. Recover it?")
    widgets.spacer()
    for name, goes_on in (("Recover it", True), ("Discard it", False)):
        entered = goes_on and imgui.is_key_pressed(imgui.Key.enter, False)
        if imgui.button(name) or entered:
            documents.answer(goes_on)
            imgui.close_current_popup()
        probe.note(f"unsaved {name}")
        imgui.same_line()
    imgui.new_line()
