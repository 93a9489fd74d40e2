"""The pause menu: go on, tired, in pain, not this attempt, finished, for the therapist. Only the
end asks again.
"""

from typing import Any

from textual.message import Message
from textual.widgets.option_list import Option

from sar_tui.model.language import Language
from sar_tui.model.messages import SessionCommand
from sar_tui.rules.scanning import Choice
from sar_tui.widgets.language import language_of
from sar_tui.widgets.lists import OptionList, menu_sentences

_WORDS = {
    "": ("Paused", "Take your time."),
    "tired": ("Have a rest", "Take all the rest you need. Nothing is lost."),
    "pain": (
        "Please stop and rest",
        "Tell your therapist or the experimenter about the pain before you go on.",
    ),
    "finished": (
        "End the session now?",
        "What you did is kept. You cannot go on with this session later.",
    ),
}
_CHOICES = {
    "": ("go on", "tired", "pain", "skip", "dismiss", "finished", "therapist"),
    "tired": ("go on", "pain", "skip", "dismiss", "finished", "therapist"),
    "pain": ("go on", "dismiss", "finished", "therapist"),
    "finished": ("go on", "end", "mistake"),
}
_LABELS = {
    "go on": "Go on",
    "tired": "I am tired",
    "pain": "I am in pain",
    "skip": "Skip this attempt",
    "dismiss": "End the visit",
    "finished": "I am finished",
    "end": "Yes, end the session",
    "mistake": "It was started by mistake",
    "therapist": "For the therapist",
}


def pause_words(reason: str, tr: Language) -> tuple[str, str]:
    """Return the title of a pause for ``reason``, and what is said to it."""
    title, words = _WORDS.get(reason, _WORDS[""])
    return tr(title), tr(words)


def pause_choices(
    reason: str,
    tr: Language,
    *,
    can_skip: bool = False,
    may_be_mistake: bool = False,
    is_visited: bool = False,
) -> dict[str, str]:
    """Return the choices in a pause for ``reason`` with their labels. ``is_visited``: somebody
    watches.
    """
    offers = {"skip": can_skip, "mistake": may_be_mistake, "dismiss": is_visited}
    found = _CHOICES.get(reason, _CHOICES[""])
    return {choice: tr(_LABELS[choice]) for choice in found if offers.get(choice, True)}


def act_of(choice: str) -> SessionCommand:
    """Return the act that a choice is, except that of the therapist."""
    match choice:
        case "go on":
            return SessionCommand(command="resume")
        case "dismiss":
            return SessionCommand(command="dismiss")
        case "skip":
            return SessionCommand(command="skip", reason="attempt")
        case "end":
            return SessionCommand(command="end", reason="finished")
        case "mistake":
            return SessionCommand(command="end", reason="mistake")
    return SessionCommand(command="pause", reason=choice)


class PauseMenu(OptionList):
    """A menu whose choices are operator acts by the participant."""

    app: Any

    class Chosen(Message):
        """The participant chose."""

        def __init__(self, act: SessionCommand) -> None:
            super().__init__()
            self.act = act

    class TherapistAsked(Message):
        """The therapist wants to change something."""

    def open(
        self,
        reason: str,
        *,
        can_skip: bool = False,
        may_be_mistake: bool = False,
        is_visited: bool = False,
    ) -> None:
        """Show the choices after a pause for ``reason``.

        ``can_skip``: the attempt may be left out. ``may_be_mistake``: the session may have been
        started by mistake. ``is_visited``: somebody watches.
        """
        tr = language_of(self.app)
        self.border_title, words = pause_words(reason, tr)
        self.border_subtitle = tr("arrows to choose, Enter to confirm")
        if switch := self.app.switch:
            self.border_subtitle = switch.how_to_choose
        self.clear_options()
        self.add_option(Option(f"{words}\n", disabled=True))
        choices = pause_choices(
            reason, tr, can_skip=can_skip, may_be_mistake=may_be_mistake, is_visited=is_visited
        )
        self.add_options([Option(label, id=choice) for choice, label in choices.items()])
        self.highlighted = 1

    @property
    def sentences(self) -> list[str]:
        """The menu in sentences: what it is about, how to choose, and the choice that is marked."""
        return menu_sentences(self)

    def on_option_list_option_highlighted(self) -> None:
        self.app.aloud.read_more()

    @property
    def switch_choices(self) -> tuple[Choice, ...]:
        """The choices of a person with a switch: all but the therapist's, who has the keys."""
        return tuple(
            Choice(str(option.prompt), ("enter",))
            for option in self.options
            if not option.disabled and option.id != "therapist"
        )

    def mark(self, at: int) -> None:
        """Highlight one of these choices. Above them are the words."""
        self.highlighted = at + 1

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        choice = event.option.id or ""
        if choice == "therapist":
            self.highlighted = 1
            self.post_message(self.TherapistAsked())
        else:
            self.post_message(self.Chosen(act_of(choice)))
