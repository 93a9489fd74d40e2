"""The four requirements of the thesis (its Table 4.2), and systems with one thing broken that must
fail them.
"""

import shutil
import tempfile
from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path
from typing import NamedTuple

import msgspec

from sar_tui import loop
from sar_tui.app.loop_graph import loop_graph
from sar_tui.loop.session import Parts
from sar_tui.validation import adaptation, broken_parts, feedback
from sar_tui.validation.bodies import PARTS, tablet_alone
from sar_tui.validation.changed_parts import TASKS, node_classes
from sar_tui.validation.changed_parts import report as changed_parts
from sar_tui.validation.evidence import EVERY, Evidence, System, collect, sessions
from sar_tui.validation.modularity import LEAST, Code, Loaded, code, load
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

CLOSE_MS = 0.01
"""Largest difference of a result from the mean of the times that it is made of: rounding."""


class Requirement(NamedTuple):
    """A requirement: what asks for it and how it is tested, as in Table 4.2; ``claims`` about the
    evidence.
    """

    name: str
    motivation: str
    validation: str
    claims: Callable[[Evidence], Sequence[Claim]]


class Control(NamedTuple):
    """A system with one thing broken, which must fail one requirement and meet the others.

    ``reaching``: counts the code of the reaching task; ``parts_of_reaching``: classes of the nodes
    in its loop.
    """

    name: str
    fails: str
    system: System = System()
    reaching: Callable[[Loaded], Code] = code
    parts_of_reaching: Parts = Parts()


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

    return sorted({"screen", "speech", "tones", "servo", "ros"} - set(output_names()))


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
        *changed_parts(evidence.graphs, evidence.nodes).claims,
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


def _with_own_framework(loaded: Loaded) -> Code:
    """Count the code of a task whose folder holds a copy of the framework."""
    with tempfile.TemporaryDirectory(prefix="sar-tui-validate-") as place:
        folder = Path(place) / "task"
        shutil.copytree(loaded.folder, folder)
        shutil.copytree(Path(loop.__file__).parent, folder / "own_framework")
        return code(msgspec.structs.replace(loaded, folder=str(folder)))


CONTROLS = (
    Control(
        "a rule that never adapts",
        "task-oriented training",
        System({"difficulty_policy": "fixed", "start_level": 5}),
    ),
    Control(
        "a rule that ignores the result",
        "task-oriented training",
        System({"difficulty_policy": "sequence", "level_sequence": (1, 2, 3, 4, 5, 6, 5, 4, 3, 2)}),
    ),
    Control(
        f"keys that are perceived {broken_parts.LATE_MS} ms late",
        "task-oriented training",
        System(parts=Parts(perception=broken_parts.LatePerception)),
    ),
    Control(
        "praise whatever the result",
        "augmented feedback",
        System(parts=Parts(event_handler=broken_parts.PraisingEventHandler)),
    ),
    Control(
        "a neutral word whatever the result", "augmented feedback", System({"neutral_band": 5000.0})
    ),
    Control(
        f"figures that are {broken_parts.WRONG_BY_MS:g} ms off",
        "augmented feedback",
        System(parts=Parts(event_handler=broken_parts.MisinformedEventHandler)),
    ),
    Control(
        "feedback after each attempt, although it is to be rare",
        "augmented feedback",
        System(rare={"feedback_schedule": "every", "feedback_every": 1}),
    ),
    Control(
        "feedback with figures, although none are wanted",
        "augmented feedback",
        System(worded={"feedback_form": "quantitative"}),
    ),
    Control(
        "an agent without a voice and without a body", "embodiment", System(bodies=tablet_alone)
    ),
    Control(
        "a level that falls when a robot moves",
        "embodiment",
        System(parts=Parts(event_handler=broken_parts.DistractedEventHandler)),
    ),
    Control(
        "a task with a framework of its own", "modular flexibility", reaching=_with_own_framework
    ),
    Control(
        "a task that needs a memory of its own",
        "modular flexibility",
        parts_of_reaching=Parts(memory=broken_parts.OwnMemory),
    ),
)
"""Each is a system that runs, set up or built wrongly on purpose."""


def run(conditions: Conditions) -> Report:
    """Return Table 4.2: one row per requirement, for the program as it is and for each control."""
    theme = conditions.catalogue.theme("calm")
    graphs = {task: loop_graph(conditions.catalogue.task(task), theme) for task in TASKS}
    nodes = {task: node_classes(conditions.catalogue.task(task), theme) for task in TASKS}
    loaded = {task: load(task, conditions.catalogue) for task in TASKS}
    counted = {task: code(one) for task, one in loaded.items()}
    systems = [Control("the program as it is", ""), *CONTROLS]
    steps = sessions(conditions) * sum(
        control.fails != "modular flexibility" for control in systems
    )
    step = count()
    rows: list[Row] = []
    whole: Evidence | None = None
    for control in systems:

        def done(name: str = control.name) -> None:
            conditions.progress(f"table-4.2: {name}", next(step), steps)

        if whole is None or control.fails != "modular flexibility":
            evidence = collect(conditions, control.system, counted, graphs, nodes, done)
            whole = whole or evidence
        else:
            changed = {**counted, "reaching": control.reaching(loaded["reaching"])}
            other = node_classes(
                conditions.catalogue.task("reaching"), theme, control.parts_of_reaching
            )
            evidence = msgspec.structs.replace(
                whole, code=changed, nodes={**nodes, "reaching": other}
            )
        rows += [_row(control, requirement, evidence) for requirement in REQUIREMENTS]
    return Report(
        rows, [_COLUMNS], [*_met(rows), *_failed(rows)], seen=[row for row in rows if _is_told(row)]
    )


def _row(control: Control, requirement: Requirement, evidence: Evidence) -> Row:
    claims = requirement.claims(evidence)
    return {
        "system": control.name,
        "must_fail": control.fails,
        "requirement": requirement.name,
        "motivation": requirement.motivation,
        "validation": requirement.validation,
        "met": all(claim.holds for claim in claims),
        "reasons": " ".join(claim.sentence for claim in claims if claim.holds),
        "against": " ".join(
            f"Not so: {claim.sentence} But {claim.against}." for claim in claims if not claim.holds
        ),
    }


def _is_told(row: Row) -> bool:
    """Return True for the program, for what a control must fail, and for what is not as it must
    be.
    """
    return row["must_fail"] in ("", row["requirement"]) or not row["met"]


def _met(rows: Sequence[Row]) -> list[Claim]:
    """Return a claim for each requirement: the program meets it."""
    return [
        Claim(
            f"The program meets the requirement of {row['requirement']}. {row['reasons']}",
            row["against"],
        )
        for row in rows
        if not row["must_fail"]
    ]


def _failed(rows: Sequence[Row]) -> list[Claim]:
    """Return a claim for each control: it fails its own requirement, and no other."""
    claims = []
    for control in CONTROLS:
        own = {row["requirement"]: row["met"] for row in rows if row["system"] == control.name}
        others = [name for name, met in own.items() if not met and name != control.fails]
        against = (
            "it meets it"
            if own[control.fails]
            else f"it fails {', '.join(others)} as well"
            if others
            else ""
        )
        claims.append(
            Claim(
                f"Broken on purpose: {control.name} fails {control.fails}, and that alone.", against
            )
        )
    return claims


def _verdict(row: Row) -> str:
    if row["must_fail"] == row["requirement"]:
        return "✗ meets it, and must not" if row["met"] else "✓ fails, as it must"
    return "✓ met" if row["met"] else "✗ not met"


_COLUMNS = (
    Column("system", lambda row: str(row["system"]), is_number=False),
    Column("requirement", lambda row: str(row["requirement"]), is_number=False),
    Column("verdict", _verdict, is_number=False),
    Column("why not", lambda row: str(row["against"]), is_number=False),
)
