"""Draw the questions about files: what lacks something, what is unsaved, what cannot be read."""

from collections.abc import Sequence

from heatlens.core.base.messages import window_words
from heatlens.core.model.depth_words import DepthSide
from heatlens.deliver.farm.export_process import ExportRun
from heatlens.studio.board.controls import FileControl
from heatlens.studio.ui.answers import ask
from heatlens.studio.ui.state import UiScale, UiState
from heatlens.studio.ui.work_bar import export_words

_LEAVE_WORDS = "The cluster can go on with it; opening the shot again shows how far it is."
_LEAVE, _STOP, _KEEP = "Leave it to the cluster and close", "Stop it and close", "Keep exporting"


def draw_questions(ui: UiState, run: ExportRun) -> None:
    """Draw the questions that wait for an answer."""
    _ask_for_scale(ui.scale)
    _ask_for_unsaved_shot(ui.files)
    _ask_about_unreadable_file(ui)
    _ask_for_depth(ui)
    _ask_for_network(ui)
    _ask_where_to_save(ui)
    _ask_for_existing_files(ui.files)
    _ask_for_version(ui)
    _ask_before_quitting(ui, run)


def _ask_about_failure(
    ui: UiState, key: str, title: str, words: str, answers: Sequence[str], escape: str = ""
) -> str:
    """Ask as `ask` does; an answer also hides the sentence that tells the same."""
    answer = ask(key, title, words, answers, escape)
    if answer:
        ui.messages.clear()
    return answer


def _ask_for_scale(scale: UiScale) -> None:
    """Ask for the size of text on a large screen whose scale is not known."""
    if not scale.is_unknown:
        return
    words = (
        f"This screen is {scale.screen_width_px} pixels wide, and the system gives no scale for "
        "it. Ctrl+plus and Ctrl+minus change the size later."
    )
    scales = {"Twice as large": 2.0, "As it is": 1.0}
    answer = ask("scale", "How large should the interface be?", words, list(scales))
    if answer:
        scale.choose(scales[answer])


def _ask_before_quitting(ui: UiState, run: ExportRun) -> None:
    """Ask what to do with a running export, when the window is closed."""
    if not ui.asks_to_quit:
        return
    state_words, can_be_left = export_words(run.state), run.can_be_left
    stop_words = "" if run.state is None else run.state.when_stopped
    words = f"{state_words}. {_LEAVE_WORDS if can_be_left else stop_words}"
    answers = [_LEAVE, _STOP, _KEEP] if can_be_left else [_STOP, _KEEP]
    answer = ask("quit", "An export is under way", words, answers)
    if answer == _STOP:
        run.cancel()
    if answer or not state_words:  # it has ended meanwhile
        ui.asks_to_quit, ui.is_over = False, answer != _KEEP


_HALVES = {"Left half": DepthSide.LEFT, "Right half": DepthSide.RIGHT}
_WITHOUT = "Open without"
_DEPTH_DIALOGS = {"Choose its depth...": "depth", "Estimate...": "network"}


def _ask_for_depth(ui: UiState) -> None:
    """Ask where the depth of a picture is that was opened without one."""
    no_depth = ui.files.commands.no_depth
    if not no_depth.name:
        return
    words = f"{no_depth.name} has no depth. Where is it?"
    answers = [*_DEPTH_DIALOGS, *_HALVES, _WITHOUT, "Cancel"]
    answer = _ask_about_failure(ui, "no depth", "No depth", words, answers)
    if answer in _HALVES:
        no_depth.use_side(_HALVES[answer])
    elif answer == _WITHOUT:
        no_depth.use_no_depth()
    elif answer:
        no_depth.end()
    if answer in _DEPTH_DIALOGS:
        ui.dialogs.ask(_DEPTH_DIALOGS[answer])


def _ask_for_network(ui: UiState) -> None:
    """Ask whether a network that a shot names may run."""
    question = ui.files.commands.unknown_network
    if not question.name:
        return
    words = (
        f"{question.name} estimates its depth with the network {question.network}, which runs like "
        "a program. Run it only if you know whose it is."
    )
    answers = ["Do not run it", "Run it"]
    answer = _ask_about_failure(ui, "network", "Unknown network", words, answers, answers[0])
    if answer == answers[1]:
        question.run_network()
    elif answer:
        question.end()


_OPEN_VERSION, _OPEN_ANOTHER = "Open the kept one", "Open another..."
_OTHER_FOLDER = "Look in another folder..."
_UNREADABLE_DIALOGS = {_OTHER_FOLDER: "media", _OPEN_ANOTHER: "open"}


def _ask_about_unreadable_file(ui: UiState) -> None:
    """Tell why a shot, a reel or unsaved changes cannot be read, and offer what there is."""
    unreadable = ui.files.documents.unreadable
    asked = unreadable.asked
    if asked is None:
        return
    words, answers = window_words(asked.reason), [] if asked.is_open else [_OPEN_ANOTHER]
    if asked.version is not None:
        words += f" Its newest version is kept: {asked.version.words}."
        answers = [_OPEN_VERSION, *answers]
    if asked.lacks_media:
        answers = [_OTHER_FOLDER, *answers]
    answers += ["Go on without" if asked.is_open else "Cancel"]
    answer = _ask_about_failure(ui, "unreadable", "Cannot be read", words, answers)
    if answer:
        unreadable.answer(opens_version=answer == _OPEN_VERSION)
    if answer in _UNREADABLE_DIALOGS:
        ui.dialogs.ask(_UNREADABLE_DIALOGS[answer])


def _ask_where_to_save(ui: UiState) -> None:
    """Tell why the shot could not be saved, and offer to save it elsewhere."""
    documents = ui.files.documents
    if not documents.failed_save:
        return
    answers = ["Save elsewhere...", "Go on unsaved"]
    answer = _ask_about_failure(ui, "failed save", "Not saved", documents.failed_save, answers)
    if answer:
        documents.failed_save = ""
    if answer == answers[0]:
        ui.dialogs.ask("save shot")


def _ask_for_existing_files(files: FileControl) -> None:
    """Ask whether to export over files that are there already."""
    exports = files.exports
    if not exports.existing_words:
        return
    words = (
        f"{exports.existing_words} Frames that are finished and as wanted stay; other frames of "
        "heatlens are replaced."
    )
    # Enter must replace nothing, so the harmless answer is the first.
    answers = ["Cancel", "Export over them"]
    answer = ask("existing", "Files are there already", words, answers, "Cancel")
    if answer:
        exports.answer_existing(exports_over=answer == "Export over them")


def _ask_for_version(ui: UiState) -> None:
    """Ask which earlier version of the shot to show as B."""
    offered = ui.files.documents.versions.offered
    if offered is None:
        return
    versions = {version.words: version for version in offered}
    words = "Which save or autosave should be B?" if versions else "No version has been saved yet."
    answer = ask("version", "Compare with a version", words, [*versions, "Cancel"], "Cancel")
    if answer:
        ui.files.documents.versions.offered = None
    if answer in versions:
        ui.files.commands.compare_with_version(versions[answer])


def _ask_for_unsaved_shot(files: FileControl) -> None:
    """Ask whether to go on with unsaved changes of an earlier time."""
    offer = files.documents.offer
    if offer is None:
        return
    go_on, start_anew = "Go on with it", "Start anew" if offer.saved is None else "Open it as saved"
    answer = ask("unsaved", "Not saved", offer.words, [go_on, start_anew], escape=go_on)
    if answer:
        files.documents.answer(recovers=answer == go_on)
