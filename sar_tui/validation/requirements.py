"""The four requirements of the thesis (its Table 4.2): claims on sessions of simulated users, and on
the code of two tasks.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import count
from typing import NamedTuple, get_args

import msgspec

from sar_tui.app.loop_graph import loop_graph
from sar_tui.loop.graph import Graph
from sar_tui.loop.session import Parts
from sar_tui.model.messages import ActionPart
from sar_tui.outputs import output
from sar_tui.outputs.output import Output
from sar_tui.validation import adaptation, feedback
from sar_tui.validation.modularity import (
    LEAST,
    TASKS,
    Code,
    Loaded,
    code,
    compared_loops,
    load,
    node_classes,
)
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated, session_runner

USERS = ("poor", "average", "competent")
EVERY = 3
"""Number of attempts per feedback, where not each attempt is to have it."""
CLOSE_MS = 0.01
"""Largest difference of a result from the mean of the times that it is made of: rounding."""
PARTS: tuple[ActionPart, ...] = get_args(ActionPart)


class Body(Output):
    """A body that performs some parts of actions.

    Attributes:
        performed: its parts, each with the id of the action.
    """

    def __init__(self, name: str, can: tuple[ActionPart, ...]) -> None:
        self.name = name
        self.can = frozenset(can)
        self.performed: list[tuple[str, ActionPart]] = []

    def say(self, action: str, text: str) -> None:
        self._perform(action, "say")

    def show(self, action: str, text: str, face: str) -> None:
        self._perform(action, "show")

    def gesture(self, action: str, name: str) -> None:
        self._perform(action, "gesture")

    def gaze(self, action: str, where: str) -> None:
        self._perform(action, "gaze")

    def tone(self, action: str, name: str) -> None:
        self._perform(action, "tone")

    def _perform(self, action: str, part: ActionPart) -> None:
        self.performed.append((action, part))
        self._send_report(output.Report(action, part, "done", self.clock.now()))


def every_body() -> tuple[Body, ...]:
    """Return a loudspeaker, a tablet and a robot that moves: together they perform every part."""
    return Body("loudspeaker", ("say", "tone")), *tablet_alone(), Body("robot", ("gesture", "gaze"))


def tablet_alone() -> tuple[Body, ...]:
    """Return a tablet that shows, and does nothing else."""
    return (Body("tablet", ("show",)),)


class Evidence(msgspec.Struct, frozen=True):
    """Evidence on one system.

    Attributes:
        sessions: of twenty attempts with feedback after each, by user and seed.
        rare: those of competent users with feedback after every three attempts, by seed.
        worded: sessions of an average user by the form of feedback that was asked for, and seed.
        bare: a session without other bodies than the screen; ``embodied``: the same one with
            ``bodies``.
        code: lines of each task's session; ``graphs``: the loops of the keyboard and the reaching
            task; ``nodes``: the classes of the nodes in them, by name.
    """

    sessions: Mapping[tuple[str, int], Simulated]
    rare: Mapping[int, Simulated]
    worded: Mapping[tuple[str, int], Simulated]
    bare: Simulated
    embodied: Simulated
    bodies: tuple[Body, ...]
    code: Mapping[str, Code]
    graphs: Mapping[str, Graph]
    nodes: Mapping[str, Mapping[str, str]]


class Requirement(NamedTuple):
    """A requirement: what asks for it and how it is tested, as in Table 4.2; ``claims`` about the
    evidence.
    """

    name: str
    motivation: str
    validation: str
    claims: Callable[[Evidence], Sequence[Claim]]


class System(msgspec.Struct, frozen=True):
    """A system that evidence is collected on: the program as it is, or with one thing broken by a
    test.

    Attributes:
        settings: of every session. ``rare``, ``worded``: more of them, for sessions in which
            feedback is to be rare, or has a form; they come last.
        bodies: returns the agent's bodies.
        parts: the classes of the framework's nodes.
        reaching: counts the code of the reaching task.
        parts_of_reaching: the classes of the nodes in its loop.
    """

    settings: Mapping[str, object] = {}
    rare: Mapping[str, object] = {}
    worded: Mapping[str, object] = {}
    bodies: Callable[[], tuple[Body, ...]] = every_body
    parts: Parts = Parts()
    reaching: Callable[[Loaded], Code] = code
    parts_of_reaching: Parts = Parts()


def run(conditions: Conditions, system: System | None = None) -> Report:
    """Return Table 4.2: one row per requirement, for the program as it is or for another system."""
    evidence = collect(conditions, system or System())
    rows = [_row(requirement, evidence) for requirement in REQUIREMENTS]
    claims = [
        Claim(
            f"The program meets the requirement of {row['requirement']}. {row['reasons']}",
            row["against"],
        )
        for row in rows
    ]
    return Report(rows, [_COLUMNS], claims)


def _row(requirement: Requirement, evidence: Evidence) -> Row:
    claims = requirement.claims(evidence)
    return {
        "requirement": requirement.name,
        "motivation": requirement.motivation,
        "validation": requirement.validation,
        "met": all(claim.holds for claim in claims),
        "reasons": " ".join(claim.sentence for claim in claims if claim.holds),
        "against": " ".join(
            f"Not so: {claim.sentence} But {claim.against}." for claim in claims if not claim.holds
        ),
    }


_COLUMNS = (
    Column("requirement", lambda row: str(row["requirement"]), is_number=False),
    Column("verdict", lambda row: "✓ met" if row["met"] else "✗ not met", is_number=False),
    Column("why not", lambda row: str(row["against"]), is_number=False),
)


def collect(conditions: Conditions, system: System) -> Evidence:
    """Run the sessions of a system, and count the code of the tasks."""
    seeds, catalogue = conditions.seeds, conditions.catalogue
    theme = catalogue.theme("calm")
    loaded = {task: load(task, catalogue) for task in TASKS}
    graphs = {task: loop_graph(catalogue.task(task), theme) for task in TASKS}
    nodes = {
        task: node_classes(catalogue.task(task), theme, parts)
        for task, parts in zip(TASKS, (Parts(), system.parts_of_reaching), strict=True)
    }
    bodies = system.bodies()
    with session_runner(catalogue, conditions.known) as runner:
        run = partial(_run, runner, system.parts, _progress(conditions))
        rare = {**system.settings, "feedback_every": EVERY, **system.rare}
        return Evidence(
            sessions={
                (user, seed): run(user, seed, system.settings) for user in USERS for seed in seeds
            },
            rare={seed: run("competent", seed, rare) for seed in seeds},
            worded={
                (form, seed): run(
                    "average", seed, {**system.settings, "feedback_form": form, **system.worded}
                )
                for form in ("qualitative", "quantitative")
                for seed in seeds[:2]
            },
            bare=run("average", seeds[0], system.settings),
            embodied=run("average", seeds[0], system.settings, bodies),
            bodies=bodies,
            code={
                "keyboard": code(loaded["keyboard"]),
                "reaching": system.reaching(loaded["reaching"]),
            },
            graphs=graphs,
            nodes=nodes,
        )


def _run(
    runner: SessionRunner,
    parts: Parts,
    done: Callable[[], None],
    user: str,
    seed: int,
    settings: Mapping[str, object],
    bodies: tuple[Body, ...] = (),
) -> Simulated:
    found = runner.run(user, seed, bodies=bodies, parts=parts, **settings)
    done()
    return found


def _progress(conditions: Conditions) -> Callable[[], None]:
    """Return a function that is called after each session."""
    sessions = (len(USERS) + 1) * len(conditions.seeds) + 2 * len(conditions.seeds[:2]) + 2
    numbers = count(1)
    return lambda: conditions.progress("table-4.2", next(numbers), sessions)


def _training(evidence: Evidence) -> Sequence[Claim]:
    rows = [
        row
        for (user, seed), done in evidence.sessions.items()
        for row in adaptation.level_rows(done, user, seed)
    ]  # fmt: skip
    unmeasured = [
        f"{row['user']}, seed {row['seed']}, attempt {row['attempt']}"
        for row in rows
        if (row["outcome"] == "success")
        != (_reached(row) and row["accuracy"] >= feedback.LEAST_ACCURACY)
    ]
    off = {
        f"{user}, seed {seed}, attempt {attempt['attempt']}": attempt["metric"]
        - done.timed[attempt["attempt"]]
        for (user, seed), done in evidence.sessions.items()
        for attempt in done.attempts
        if attempt["metric"] is not None
    }
    wrong = [f"{attempt}: {by:+.0f} ms" for attempt, by in off.items() if abs(by) > CLOSE_MS]
    return (
        Claim(
            f"In {len(off)} attempts, the result is the mean time from the prompt on the screen to "
            f"the key, within {CLOSE_MS:g} ms.",
            _listed(wrong),
        ),
        Claim(
            "Each attempt has an outcome that follows from its mean reaction time.",
            _listed(unmeasured),
        ),
        adaptation.follows_results(rows),
        adaptation.ranks_users(rows),
    )


def _reached(row: Row) -> bool:
    return row["reaction_time_ms"] is not None and row["reaction_time_ms"] < row["goal_ms"]


def _feedback(evidence: Evidence) -> Sequence[Claim]:
    rows = [
        row
        for (user, seed), done in evidence.sessions.items()
        for row in feedback.feedback_rows(done, user, seed)
    ]
    wrong = [
        f"{row['user']}, seed {row['seed']}, attempt {row['attempt']}"
        for row in rows
        if not feedback.fits(row)
    ]
    rare = [
        f"seed {seed}, attempt {attempt['attempt']}"
        for seed, done in evidence.rare.items()
        for attempt in done.attempts
        if (attempt["attempt"] in done.feedback) != (attempt["attempt"] % EVERY == 0)
    ]
    untrue = [
        row["text"]
        for (form, seed), done in evidence.worded.items()
        for row in feedback.said_rows(form, seed, done)
        if form == "quantitative" and not feedback.is_true(row)
    ]
    texts: dict[str, list[str]] = {"qualitative": [], "quantitative": []}
    for (form, _), done in evidence.worded.items():
        texts[form] += [each["final"]["text"] for each in done.feedback.values()]
    return (
        Claim(
            "Feedback is positive under the goal, negative over it, and neutral near it.",
            _listed(wrong),
        ),
        *feedback.differs_by_user(rows),
        Claim(
            "With feedback after every three attempts, those have it, and no others.", _listed(rare)
        ),
        *feedback.has_its_form(texts),
        Claim(feedback.TRUE_FIGURES, _listed(untrue)),
    )


def _embodiment(evidence: Evidence) -> Sequence[Claim]:
    done = {
        (report.action, report.part)
        for report in evidence.embodied.reports
        if report.state == "done"
    }
    performed = {part for _, part in done}
    lost = [part for part in PARTS if part in ("say", "show", "gesture") and part not in performed]
    bodies = {body.name for body in evidence.bodies if body.performed}
    bare, embodied = evidence.bare, evidence.embodied
    differing = [
        str(one["attempt"])
        for one, other in zip(bare.attempts, embodied.attempts, strict=False)
        if any(one[name] != other[name] for name in ("level", "metric", "outcome", "feedback"))
    ]
    said = [
        {key: row["final"]["text"] for key, row in done.feedback.items()}
        for done in (bare, embodied)
    ]
    return (
        Claim(
            "What the agent does is spoken, shown and gestured, by different bodies.",
            f"nothing performs: {', '.join(lost)}"
            if lost
            else ""
            if len(bodies) >= 2
            else "there is one body",
        ),
        Claim(
            "Another body changes neither the course of a session nor what is said.",
            ", ".join(differing) or ("" if said[0] == said[1] else "the feedback differs"),
        ),
        Claim(
            "Screen, speech, tones, motors and robots are there to choose from.",
            ", ".join(_missing_outputs()),
        ),
    )


def _missing_outputs() -> list[str]:
    from sar_tui.outputs.outputs import output_names

    robots = {"ros", "ros4hri", "furhat", "reachy"}
    return sorted(({"screen", "speech", "tones", "servo"} | robots) - set(output_names()))


def _modularity(evidence: Evidence) -> Sequence[Claim]:
    shares = {task: sum(code.shared.values()) / (sum(code.shared.values()) + sum(code.own.values()))
              for task, code in evidence.code.items()}  # fmt: skip
    counted = ", ".join(f"{task} {share:.0%}" for task, share in shares.items())
    short = [f"{task} {share:.0%}" for task, share in shares.items() if share < LEAST]
    return (
        Claim(
            f"At least {LEAST:.0%} of the code that each task runs is shared ({counted}).",
            ", ".join(short),
        ),
        *compared_loops(evidence.graphs, evidence.nodes).claims,
    )


def _listed(wrong: Sequence[str]) -> str:
    more = f"; and {len(wrong) - 3} more" if len(wrong) > 3 else ""
    return "; ".join(wrong[:3]) + more


REQUIREMENTS = (
    Requirement(
        "task-oriented training",
        "quantifiable performance, quantifiable difficulty, an algorithm for the difficulty",
        "simulated users do the keyboard task",
        _training,
    ),
    Requirement(
        "augmented feedback",
        "feedback of several types and frequencies",
        "simulated users do the keyboard task",
        _feedback,
    ),
    Requirement(
        "embodiment", "several media", "the same session with and without other bodies", _embodiment
    ),
    Requirement(
        "modular flexibility",
        "several tasks on one framework",
        "code and loop of the reaching task beside those of the keyboard task",
        _modularity,
    ),
)
