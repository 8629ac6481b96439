"""The question after a crash: go on with the shot as it was not saved, or as it was?"""

from imgui_bundle import ImVec2, imgui

from heatlens.printable import printable
from heatlens.session.shot_documents import ShotDocuments
from heatlens.ui import probe, topmost, widgets

_TITLE = "Not saved###unsaved shot"
_WIDTH_EM = 30.0


def shot_question(documents: ShotDocuments) -> None:
    """Draw it while there is an offer."""
    offer = documents.offer
    if offer is None:
        return
    if not imgui.is_popup_open(_TITLE):
        imgui.open_popup(_TITLE)
    em, screen = imgui.get_font_size(), imgui.get_main_viewport()
    imgui.set_next_window_size(ImVec2(_WIDTH_EM * em, 0))
    imgui.set_next_window_pos(screen.get_center(), imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    flags = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize
    shown, _ = imgui.begin_popup_modal(_TITLE, None, flags)
    if not shown:
        return
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
    imgui.end_popup()
