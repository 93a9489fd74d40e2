"""The plan of a session: the one place where names and values become a task with checked
parameters.
"""

import secrets
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
from msgspec.structs import replace

from sar_tui.loop.session import problem_of_nodes
from sar_tui.loop.task import Task
from sar_tui.model.language import Sentence, error_text, joined
from sar_tui.model.session_mode import SessionMode
from sar_tui.model.step import Step
from sar_tui.model.study_place import StudyPlace
from sar_tui.plugin_calls import PLUGIN_ERRORS, describe
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import TaskParameters, build, usable
from sar_tui.rules.questions import chosen, current, problem_of
from sar_tui.store.database import StoreError
from sar_tui.store.participants import check_own
from sar_tui.store.programmes import Programme
from sar_tui.theme_folder import languages


class Plan(msgspec.Struct, frozen=True):
    """Everything that is decided before a session starts. Made, and checked, by ``make_plan``.

    Attributes:
        partner: the code of the participant at seat B, in a task for two.
        id: the session's id; if empty, it is drawn when the session starts.
        programme: the version of the participant's programme; None if there is none.
        left_out: values of the programme that this version of the task cannot use, and for each why
            not.
        steps: between attempts, beside the task's own.
        study: the place in a study; None if it is of none.
    """

    task: type[Task]
    parameters: TaskParameters
    theme: str
    participant: str
    seed: int
    mode: SessionMode = "live"
    partner: str = ""
    id: str = ""
    programme: int | None = None
    left_out: Mapping[str, str] = {}
    steps: tuple[Step, ...] = ()
    study: StudyPlace | None = None

    @property
    def participants(self) -> tuple[str, ...]:
        """The participants' codes, by seat."""
        return tuple(filter(None, (self.participant, self.partner)))


class Failed(Exception):
    """A session cannot start or continue. Its message is one or two clear sentences."""


class EnoughToday(Failed):
    """The participant has done what the programme allows on a day."""


def make_plan(
    catalogue: Catalogue,
    task: type[Task] | str,
    participants: Sequence[str],
    settings: Mapping[str, object] = {},
    *,
    saved: Programme | None = None,
    theme: str | None = None,
    speech: str | None = None,
    seed: int | None = None,
    mode: SessionMode = "live",
    id: str = "",
    steps: tuple[Step, ...] = (),
    study: StudyPlace | None = None,
) -> Plan:
    """Plan a session, and check everything that can be checked before its devices are opened.

    Args:
        catalogue: where the task and the theme are found.
        task: the task or its name.
        participants: codes in the order of the task's seats; a simulated session makes up the
            second if it is missing.
        settings: values of the task's parameters, typed or as text; they override the saved ones. A
            start level among them is fixed.
        saved: the programme of the first participant. Values that the task cannot use any more are
            left out.
        theme: name of the theme; by default the saved one.
        speech: overrides the setting of that name, and adds speech to the outputs.
        seed: decides everything random; drawn by default.
        mode: live, simulated, or of a demonstration.
        id: the session's id; drawn when the session starts by default.
        steps: between attempts, beside the task's own (see `rules.questions.read_steps`).
        study: its place in a study.

    Raises:
        StoreError: a code is not valid, or of another site, or the codes do not match the task's
            seats.
        PluginError: there is no such task or theme.
        ParameterError: a setting is unknown or out of bounds, or there is no such output, language
            or level.
        Failed: the task cannot be set up.
    """
    saved = saved or Programme()
    kind = catalogue.task(task) if isinstance(task, str) else task
    codes = [check_own(code) for code in participants]
    if mode == "simulated" and len(codes) == 1 < len(kind.seats):
        codes.append(f"{codes[0]}-B")
    check_seats(kind, codes)
    kept, left_out = usable(kind.Parameters, saved.parameters)
    if "start_level" in settings:
        settings = {"start_from": "fixed", **settings}
    parameters = _parameters(kind, {**kept, **settings}, speech)
    parameters = replace(parameters, questions=current(parameters.questions))
    name = saved.theme if theme is None else theme
    catalogue.theme(name, parameters.language)
    check_language(parameters.language, catalogue.theme_folder(name))
    built = set_up(kind, parameters)
    if parameters.switch != "none" and not built.switch_key:
        problem = f"The task {kind.name} needs several keys, so it cannot be done with a switch."
        raise ParameterError({"switch": problem})
    own = built.steps
    if why := problem_of((*own, *chosen(parameters.questions, parameters.questions_every), *steps)):
        raise ParameterError(
            {"questions": f"{why} The task, the settings and a file of steps may each bring some."}
        )
    return Plan(
        task=kind,
        parameters=parameters,
        theme=name,
        participant=codes[0],
        seed=secrets.randbelow(2**31) if seed is None else seed,
        mode=mode,
        partner=codes[1] if len(codes) > 1 else "",
        id=id,
        programme=saved.version or None,
        left_out=left_out,
        steps=steps,
        study=study,
    )


def left_out_text(plan: Plan) -> str:
    """Return sentences on the values of the programme that are left out; empty if all are used."""
    if not plan.left_out:
        return ""
    return Sentence(
        "Version {version} of the programme of {who} is not used in full. {reasons}",
        version=plan.programme,
        who=plan.participant,
        reasons=joined(plan.left_out.values()),
    )


def _parameters(
    kind: type[Task], values: Mapping[str, object], speech: str | None
) -> TaskParameters:
    if speech is None:
        return build(kind.Parameters, values)
    values = {**values, "speech": speech}
    parameters = build(kind.Parameters, values)
    if "speech" in parameters.outputs:
        return parameters
    return build(kind.Parameters, {**values, "outputs": [*parameters.outputs, "speech"]})


def check_seats(task: type[Task], codes: Sequence[str]) -> None:
    """Raise StoreError unless the codes are different and as many as the task has seats."""
    problem = ""
    if len(codes) > 2:
        problem = Sentence("At most two participants can take part.")
    elif len(codes) > len(task.seats):
        text = "The task {task} is for one: name one participant only."
        problem = Sentence(text, task=task.name)
    elif len(codes) < len(task.seats):
        text = (
            "The task {task} is for two: name the participant on the left, and then the one on "
            "the right."
        )
        problem = Sentence(text, task=task.name)
    elif len(set(codes)) < len(codes):
        text = "{who} cannot sit at both seats: name two participants."
        problem = Sentence(text, who=codes[0])
    if problem:
        raise StoreError(problem, bad_input=True)


def check_language(language: str, folder: Path) -> None:
    """Raise ParameterError if a theme has no phrases in a language.

    A theme uses English for single phrases that it lacks, but a language without any phrase is
    probably a typing error.
    """
    known = languages(folder)
    if language.partition("-")[0] not in {name.partition("-")[0] for name in known}:
        problem = (
            f"The theme {folder.name} has no phrases in {language}; it has: {', '.join(known)}."
        )
        raise ParameterError({"language": problem})


def check_outputs(parameters: TaskParameters) -> None:
    """Raise ParameterError if ``outputs`` names an output that does not exist, or ``speech`` cannot
    be played.
    """
    from sar_tui.outputs.output import OutputError
    from sar_tui.outputs.outputs import check_outputs as check

    try:
        check(parameters.outputs, parameters.speech)
    except OutputError as error:
        raise ParameterError({"outputs": error_text(error)}) from error


def set_up(kind: type[Task], parameters: TaskParameters) -> Task:
    """Return the task with its parameters.

    Raises:
        ParameterError: there is no such output, or the task does not have the start level or the
            lowest level.
        Failed: the task raised.
    """
    # the check loads the sound library
    if (parameters.outputs, parameters.speech) != (
        ("screen",),
        "sound",
    ):
        check_outputs(parameters)
    return without_outputs(kind, parameters)


def without_outputs(kind: type[Task], parameters: TaskParameters) -> Task:
    """Return the task with its parameters, whose outputs are not opened and may be missing here.

    Raises:
        ParameterError: the task does not have the start level or the lowest level.
        Failed: the task raised.
    """
    try:
        task = kind(parameters)
        levels = task.levels
        nodes = list(task.nodes())
        wrong_steps = problem_of(task.steps)
    except PLUGIN_ERRORS as error:
        raise Failed(f"The task {kind.name} cannot be set up ({describe(error)}).") from error
    if wrong := problem_of_nodes(nodes):
        raise Failed(f"The task {kind.name} cannot be set up: {wrong}")
    if type(levels) is not int or levels < 1:
        raise Failed(
            f"The task {kind.name} cannot be set up: its levels are {levels!r}, not a whole "
            "number from 1 on."
        )
    if wrong_steps:
        raise Failed(f"The task {kind.name} cannot be set up. {wrong_steps}")
    for name in ("start_level", "min_level"):
        if (level := getattr(parameters, name)) > levels:
            raise ParameterError(
                {
                    name: f"With these settings the task {kind.name} has {levels} levels; there "
                    f"is no level {level}."
                }
            )
    return task
