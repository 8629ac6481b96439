"""The board of a session: plain values out, commands and requests in.

A front end needs nothing else. Named commands take no values ("Undo"), requests are values
(`Focus(2.4)`), and changes are new values for some fields of the lens, the blur or the view. All of
them can be written as a JSON object as well:

    {"do": "Undo"}
    {"do": "Focus", "distance_m": 2.4}
    {"change": "lens", "f_stop": 2.0, "focal_length_mm": 35}
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import get_type_hints

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.messages import Lasting
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.view.view import ViewState
from heatlens.media.files.json_record import JsonEntry
from heatlens.studio.board.command import Command, CommandState, CommandStates, in_menu_order
from heatlens.studio.board.commands import named_commands
from heatlens.studio.board.facts import Facts
from heatlens.studio.board.requests import Request
from heatlens.studio.board.session import Session
from heatlens.studio.board.state_json import StateJson
from heatlens.studio.board.user_keys import problem_of_keys, read_user_keys, with_user_keys

_MESSAGE = Path("message")  # where a wrong value was found, as errors name it
REQUESTS: Mapping[str, type[Request]] = {kind.__name__: kind for kind in Request.__subclasses__()}
# The fields that pages in a browser may change.
REMOTE_FIELDS: Mapping[str, tuple[str, ...]] = {
    "lens": ("focal_length_mm", "f_stop", "focus_distance_m"),
    "blur": ("quality",),
    "view": ("exposure_stops", "gamma", "depth_of_field", "unit"),
}
Changeable = Lens | DefocusSettings | ViewState


class Board:
    """Drives a session for a front end; errors are shown as its message."""

    def __init__(
        self, session: Session, make_still: Callable[[], str | None] = lambda: None
    ) -> None:
        """Create it; `make_still` returns the present picture as a still for a look, or None."""
        self._session = session
        self._keys, problem = read_user_keys(session.preferences.path)
        self._own = named_commands(session, make_still)
        self.commands = self._keyed(self._own)
        if problem:
            session.messages.notify(Lasting(problem))
        self._named = {command.name: command for command in self.commands}
        self._command_states = CommandStates(self.commands)
        self._facts, self._moment = session.facts, (-1, 0)
        self._read_shot = session.editing.shot  # that `_facts` were read with, or an equal one
        self._json = StateJson(self.remote_commands)

    def with_commands_of(self, front_end: Iterable[Command]) -> tuple[Command, ...]:
        """Return all commands in the order of the menus, together with those of a front end.

        Say in the session's message which keys of the user's file mean something else now.
        """
        together = (*self._own, *front_end)
        problem = problem_of_keys(together, self._keys)
        if problem:
            self._session.messages.notify(Lasting(problem))
        return self._keyed(together)

    def _keyed(self, commands: Iterable[Command]) -> tuple[Command, ...]:
        return with_user_keys(in_menu_order(commands), self._keys)

    # Panels write what they show with one value changed, so a shot from before a change of the same
    # turn would undo that change.
    @property
    def facts(self) -> Facts:
        """What is true in this turn; the same object until the turn or a change has other facts."""
        session, facts = self._session, self._facts
        editing, view = session.editing, session.pictures.view.state
        moment, is_edited = (session.moment, editing.frame), self._read_shot is not editing.shot
        if is_edited or moment != self._moment or (facts.lens, facts.view) != (editing.lens, view):
            self._moment, self._read_shot, new_facts = moment, editing.shot, session.facts
            self._facts = facts if new_facts == facts else new_facts
        return self._facts

    def command_states(self) -> tuple[CommandState, ...]:
        """Return which commands are on and which are barred, in the order of `commands`."""
        return self._command_states.present()

    def json_state(self) -> dict[str, object]:
        """Return the facts as entries of JSON, with the commands that pages may give.

        They are the same object as last time if nothing has changed.
        """
        return self._json.entries(self.facts, self.command_states())

    def do(self, action: Request | Command | str) -> None:
        """Do a request, a command, or the command of this name; show why if that is impossible."""
        try:
            self._do(action)
        except HeatlensError as error:
            self._session.show_error(error)
        self._session.moment += 1

    def _do(self, action: Request | Command | str) -> None:
        """Do an action. Raises HeatlensError if that is impossible."""
        if isinstance(action, Request):
            action.run(self._session)
        else:
            (self._named[action] if isinstance(action, str) else action).do()

    def change(self, changed: Changeable) -> None:
        """Replace the lens at the playhead, the settings of the blur, or the view."""
        editing = self._session.editing
        if isinstance(changed, Lens):
            editing.edit_lens(changed)
        elif isinstance(changed, DefocusSettings):
            editing.edit(replace(editing.shot, defocus=changed))
        else:
            self._session.pictures.view.state = changed

    def choose(self, changed: Changeable) -> None:
        """Change one of the objects as `change` does; this is an undo step of its own."""
        self._session.editing.settle()
        self.change(changed)
        self._session.editing.settle()

    @property
    def remote_commands(self) -> tuple[Command, ...]:
        """The commands that pages in a browser may give."""
        return tuple(command for command in self.commands if command.is_remote)

    def check_remote(self, message: Mapping[str, object]) -> None:
        """Raise InputError for a message of a page that asks for what pages may not do."""
        if "change" in message:
            of = message["change"]
            allowed = REMOTE_FIELDS.get(of, ()) if isinstance(of, str) else ()
            wrong = [name for name in message if name != "change" and name not in allowed]
            if wrong:
                may = ", ".join(allowed) or f"{', '.join(REMOTE_FIELDS)} after 'change'"
                raise InputError(f"A page cannot change {wrong[0]!r}; it can change {may}.")
        name = message.get("do")
        if isinstance(name, str) and not self._is_remote(name):
            raise InputError(
                f"A page has no {name!r}: files are opened and written only in the window."
            )

    def _is_remote(self, name: str) -> bool:
        """Return True for a command or a request that pages may name."""
        named: Command | type[Request] | None = self._named.get(name, REQUESTS.get(name))
        return named is not None and named.is_remote

    def turns_lens(self, message: Mapping[str, object]) -> bool:
        """Return True for a message that changes the shot or the playhead."""
        if "change" in message:
            return message["change"] != "view"
        command = self._named.get(str(message.get("do")))
        return command is None or command.turns_lens

    def answer(self, message: object) -> dict[str, object]:
        """Follow a JSON message; return `{"state": ...}`, or `{"problem": sentence}`."""
        try:
            self.follow(message)
        except HeatlensError as error:
            return {"problem": str(error)}
        return {"state": self.json_state()}

    def follow(self, data: object) -> None:
        """Follow a JSON message. Raise HeatlensError with a sentence if that is impossible."""
        message = JsonEntry(path=_MESSAGE, place="", value=data)
        if not isinstance(data, dict):
            message.refuse("it should be an object in braces")
        entries = dict(data)
        if "change" in entries:
            of = JsonEntry(_MESSAGE, "change", entries.pop("change")).choice(list(self._changing()))
            self.change(_changed(self._changing()[of], JsonEntry(_MESSAGE, "", entries)))
        elif "do" in entries:
            name = JsonEntry(path=_MESSAGE, place="do", value=entries.pop("do")).text()
            self._do(self._asked(name, JsonEntry(path=_MESSAGE, place="", value=entries)))
        elif entries:
            message.refuse("one of the entries 'do' and 'change' is missing")

    def _asked(self, name: str, values: JsonEntry) -> Request | str:
        """Return the request of a message, or the name of a command. Raises InputError."""
        if name in REQUESTS:
            return values.record(REQUESTS[name])
        if name not in self._named:
            raise InputError(f"There is no command and no request {name!r}.")
        values.members(())
        return name

    def _changing(self) -> dict[str, Changeable]:
        """Return the objects that a message may change, by their names in messages."""
        facts = self.facts
        return {"lens": facts.lens, "blur": facts.shot.defocus, "view": facts.view}


def _changed(now: Changeable, values: JsonEntry) -> Changeable:
    """Return a copy of the object with the fields that a message gives."""
    hints = get_type_hints(type(now))
    new_values = {
        name: entry.convert(hints[name])
        for name, entry in values.members([field.name for field in fields(now)]).items()
    }
    return values.build(partial(replace, now), new_values)
