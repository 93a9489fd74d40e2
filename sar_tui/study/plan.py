"""The plan of a study, as a file declares it: groups, conditions, visits with blocks, allocation.

A plan says everything that distinguishes one session from another. It is read from TOML, and
checked as far as that is possible without tasks, themes and people (`study.conditions` checks the
rest).
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import msgspec

from sar_tui.model.toml_lines import Key, TomlError, TomlLines, decode
from sar_tui.store.database import StoreError
from sar_tui.study.outcome import MEASURES, Outcome, read_power

ALLOCATED = "as allocated"
"""In place of a condition: that of the person's group."""
Order = Literal["fixed", "latin square", "williams"]
OWN = "own"
"""Level at which the person is expected to reach the goal, from earlier sessions of the task."""
_NAME = re.compile(r"[a-z][a-z0-9-]{0,31}")
NAMED = "begins with a letter a to z, and has letters, digits and - only, at most 32"
"""Rule of names, for people."""
_LONGEST_TEXT = 2000
_TOO_LONG = f"Instructions have at most {_LONGEST_TEXT} characters."


QUESTIONS = {
    "data": "Have any data been collected for this study already?",
    "hypothesis": "What's the main question being asked or hypothesis being tested in this study?",
    "outcome": "Describe the key dependent variable(s) specifying how they will be measured.",
    "conditions": "How many and which conditions will participants be assigned to?",
    "analysis": "Specify exactly which analyses you will conduct to examine the main "
    "question/hypothesis.",
    "exclusions": "Describe exactly how outliers will be defined and handled, and your precise "
    "rule(s) for excluding observations.",
    "people": "How many observations will be collected or what will determine sample size?",
    "other": "Anything else you would like to pre-register?",
    "type": "Type of study and name.",
}
"""AsPredicted's questions by the keys under ``[prereg]`` with which a plan answers them itself."""


class PlanError(ValueError):
    """A plan cannot be used. The message names the file, the line, and the reason."""


class _Declared(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of the parts of a plan."""


class Condition(_Declared, frozen=True, kw_only=True):
    """A complete setting of a session.

    Attributes:
        task: name of the task. ``theme``: of the agent's theme.
        settings: of the task; all others have their defaults. Those that the plan lists in
            ``from_person`` are of the participant's programme.
        title: its name for people.
        instructions: to be read before the first attempt, after those of the block.
    """

    task: str
    theme: str = "calm"
    settings: dict[str, Any] = {}
    title: str = ""
    instructions: str = ""


class Group(_Declared, frozen=True, kw_only=True):
    """A group that people are allocated to.

    Attributes:
        condition: of blocks whose condition is "as allocated".
        weight: how many people it gets, relative to the other groups.
    """

    condition: str
    weight: int = 1
    title: str = ""


class Block(_Declared, frozen=True, kw_only=True):
    """A part of a visit: a session of a task, or a form.

    Attributes:
        name: within its visit.
        condition: name of a condition, or "as allocated".
        conditions: several, one after another, in the person's own ``order``.
        order: of ``conditions``: as they are listed, by a balanced Latin square, or by a Williams
            design.
        form: name of the form to fill in, in place of a condition.
        purpose: of the block in the analysis. A ``probe``, a ``retention`` or a ``transfer`` block
            gives no feedback.
        attempts, practice: numbers of attempts; None: those of the condition.
        level: a level that stays fixed at the start; "own"; "VISIT/BLOCK", the last level of that
            block; None: the condition's start level.
        rest_s: rest before it.
        instructions: to be read before it.
    """

    name: str
    condition: str = ""
    conditions: tuple[str, ...] = ()
    order: Order = "fixed"
    form: str = ""
    purpose: Literal["training", "practice", "probe", "retention", "transfer"] = "training"
    attempts: int | None = None
    practice: int | None = None
    level: int | str | None = None
    rest_s: int = 0
    instructions: str = ""

    @property
    def gives_feedback(self) -> bool:
        """True unless it measures what is left without feedback."""
        return self.purpose in ("training", "practice")


class Visit(_Declared, frozen=True, kw_only=True):
    """A day on which a person comes.

    Attributes:
        day: counted from the first visit, which is day 0.
        window: days before and after that day on which it may be: (2, 3) is from 2 days earlier to
            3 days later.
        blocks: in order.
    """

    name: str
    title: str = ""
    day: int = 0
    window: tuple[int, int] = (0, 0)
    blocks: tuple[Block, ...]


class Interrupted(_Declared, frozen=True, kw_only=True):
    """The rule for a block whose session was cut off.

    Attributes:
        resume_hours: for so long it goes on where it was.
        then: later: begin the block again, or leave it as it is.
    """

    resume_hours: float = 24.0
    then: Literal["restart", "leave"] = "restart"


class Allocation(_Declared, frozen=True, kw_only=True):
    """The method by which people come to groups, and to orders of conditions.

    Attributes:
        method: ``simple``: each independent of the others; ``blocks`` of random ``sizes`` within
            strata; ``minimisation`` (Pocock and Simon 1975) that follows the balance with the
            probability ``certainty``; ``big stick`` (Soares and Wu 1983), simple until the groups
            differ by ``largest_difference``; ``list``: made elsewhere.
        sizes: of blocks, multiples of the sum of weights.
        strata: factors that are asked at enrolment, with their values, besides the site.
        blind: True if nobody who works with participants may know the groups: screens, files and
            logs have neutral codes.
    """

    method: Literal["simple", "blocks", "minimisation", "big stick", "list"] = "blocks"
    sizes: tuple[int, ...] = ()
    strata: dict[str, tuple[str, ...]] = {}
    certainty: float = 0.8
    largest_difference: int = 3
    blind: bool = False


class Consent(_Declared, frozen=True, kw_only=True):
    """The consent without which no session starts.

    Attributes:
        version: of the text that people agree to.
        scope: parts that are agreed to one by one, such as "video".
        witness: True if a witness must be named by a code.
    """

    version: str
    scope: tuple[str, ...] = ()
    witness: bool = False


class Study(_Declared, frozen=True, kw_only=True):
    """The plan of a study.

    Attributes:
        from_person: settings that belong to the person or the place, and are taken from the
            participant's programme.
        missed: what becomes of a visit whose window is over: it may be made up ``late``, with a
            reason, until the next visit's window begins; it is left out (``skip``) at once; or the
            person takes no further part (``stop``).
        power: assumptions for `sar-tui study power`.
        prereg: answers to AsPredicted's `QUESTIONS` that do not follow from the plan.
    """

    name: str
    version: int = 1
    title: str = ""
    sites: tuple[str, ...] = ()
    hypothesis: str = ""
    groups: dict[str, Group] = {}
    conditions: dict[str, Condition]
    visits: tuple[Visit, ...]
    outcome: Outcome | None = None
    allocation: Allocation = Allocation()
    consent: Consent | None = None
    interrupted: Interrupted = Interrupted()
    missed: Literal["late", "skip", "stop"] = "late"
    from_person: tuple[str, ...] = (
        "language", "imu", "imu_trunk", "hand", "switch", "scan_interval_ms", "bounce_ms",
        "system_keys", "added_delay_ms", "outputs", "speech", "read_aloud", "layout",
    )  # fmt: skip
    people: int = 0
    power: dict[str, Any] = {}
    prereg: dict[str, str] = {}

    @property
    def squares(self) -> dict[tuple[str, ...], Order]:
        """Sets of conditions whose order differs between people, and how."""
        return {
            block.conditions: block.order
            for _, block in self.blocks()
            if block.conditions and block.order != "fixed"
        }

    def blocks(self) -> Iterator[tuple[Visit, Block]]:
        """Yield all blocks with their visits, in order."""
        return ((visit, block) for visit in self.visits for block in visit.blocks)

    def visit(self, name: str) -> Visit:
        """Return a visit by its name. Raises KeyError."""
        return {visit.name: visit for visit in self.visits}[name]

    def block(self, visit: str, name: str) -> Block:
        """Return a block of a visit. Raises KeyError."""
        return {block.name: block for block in self.visit(visit).blocks}[name]


# --- reading


def read_plan(path: Path) -> str:
    """Return the text of a plan. Raises PlanError."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise PlanError(f"{path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError:
        raise PlanError(f"{path} is not a text in UTF-8.") from None


def parse_plan(text: str, name: str) -> Study:
    """Return the plan in a TOML text; ``name`` is that of its file, for messages.

    Raises:
        PlanError: it is no TOML, or declares something that cannot be. The message has a line for
            each mistake.
    """
    lines = TomlLines(text, name)
    try:
        content = decode(text)
    except TomlError as error:
        raise PlanError(f"{name}, {error}") from error
    if found := [*_unreadable_parts(content, lines)]:
        raise PlanError("\n".join(found))
    try:
        plan = msgspec.convert(content, Study)
    except msgspec.ValidationError as error:
        raise PlanError(lines.invalid(str(error), kind=Study)) from error
    if problems := [lines.at(key, problem) for key, problem in _problems(plan)]:
        raise PlanError("\n".join(dict.fromkeys(problems)))
    return plan


def _unreadable_parts(content: dict[str, Any], lines: TomlLines) -> Iterator[str]:
    """Yield a message on each table that does not have the fields and types of a plan. Of a table
    with several mistakes it is the first.
    """
    for key, values, kind in _parts(content):
        try:
            msgspec.convert(values, kind)
        except msgspec.ValidationError as error:
            yield lines.invalid(str(error), key, kind)


def _parts(content: dict[str, Any]) -> Iterator[tuple[Key, Any, type[_Declared]]]:
    """Yield the tables of a plan, each with its place and its type, and without the tables in it."""
    whole = dict(content)
    for name, kind in (("groups", Group), ("conditions", Condition)):
        if isinstance(tables := content.get(name), dict):
            whole[name] = {}
            yield from (((name, each), tables[each], kind) for each in tables)
    if isinstance(visits := content.get("visits"), list):
        whole["visits"] = []
        for at, visit in enumerate(visits):
            if isinstance(visit, dict) and isinstance(blocks := visit.get("blocks"), list):
                yield ("visits", at), visit | {"blocks": []}, Visit
                for number, block in enumerate(blocks):
                    yield ("visits", at, "blocks", number), block, Block
            else:
                yield ("visits", at), visit, Visit
    yield (), whole, Study


Problem = tuple[Key, str]
"""A place in the file where something is wrong, and a sentence on it."""


def _problems(plan: Study) -> Iterator[Problem]:
    """Yield what cannot be, in the order of the file."""
    yield from _names(plan)
    for name, condition in plan.conditions.items():
        if len(condition.instructions) > _LONGEST_TEXT:
            yield ("conditions", name, "instructions"), _TOO_LONG
    if plan.version < 1:
        yield ("version",), f"The version is a whole number from 1 on, not {plan.version}."
    for name, group in plan.groups.items():
        if group.condition not in plan.conditions:
            yield ("groups", name, "condition"), _no_condition(plan, group.condition)
        if group.weight < 1:
            yield ("groups", name, "weight"), "A weight is a whole number from 1 on."
    if len(plan.groups) == 1:
        yield ("groups",), "A study has no groups, or two or more."
    if not plan.visits:
        yield ("visits",), "A study has one visit or more."
    for at, visit in enumerate(plan.visits):
        yield from _visit_problems(plan, at, visit)
    yield from _allocation_problems(plan)
    yield from _outcome_problems(plan)


def _names(plan: Study) -> Iterator[Problem]:
    named: list[Problem] = [(("name",), plan.name)]
    named += [(("groups", name), name) for name in plan.groups]
    named += [(("conditions", name), name) for name in plan.conditions]
    for at, visit in enumerate(plan.visits):
        named.append((("visits", at, "name"), visit.name))
        named += [
            (("visits", at, "blocks", number, "name"), block.name)
            for number, block in enumerate(visit.blocks)
        ]
    for key, name in named:
        if not is_name(name):
            yield key, f"A name {NAMED}, unlike {name!r:.40}."
    for at in _repeated([visit.name for visit in plan.visits]):
        yield ("visits", at, "name"), f"Two visits are named {plan.visits[at].name!r}."


def is_name(text: str) -> bool:
    """Return True if something in a plan can have this name."""
    return _NAME.fullmatch(text) is not None


def _repeated(names: list[str]) -> Iterator[int]:
    """Yield where a name stands that was there before."""
    return (at for at, name in enumerate(names) if name in names[:at])


def _no_condition(plan: Study, name: str) -> str:
    return f"There is no condition {name!r}. There are: {', '.join(plan.conditions)}."


def _visit_problems(plan: Study, at: int, visit: Visit) -> Iterator[Problem]:
    here = ("visits", at)
    before, after = visit.window
    if before < 0 or after < 0:
        yield (*here, "window"), "A window is two numbers of days, from 0 on: before and after."
    earlier = plan.visits[at - 1] if at else None
    if earlier and visit.day <= earlier.day:
        yield (*here, "day"), f"Day {visit.day} is not after that of the visit {earlier.name}."
    if not visit.blocks:
        yield here, f"The visit {visit.name} has no blocks."
    for number in _repeated([block.name for block in visit.blocks]):
        said = f"Two blocks of the visit {visit.name} are named {visit.blocks[number].name!r}."
        yield (*here, "blocks", number, "name"), said
    for number, block in enumerate(visit.blocks):
        for key, problem in _block_problems(plan, visit, block):
            yield (*here, "blocks", number, *key), problem


def _block_problems(plan: Study, visit: Visit, block: Block) -> Iterator[Problem]:
    given = [name for name in ("condition", "conditions", "form") if getattr(block, name)]
    if len(given) != 1:
        yield (), f"The block {block.name} has either a condition, conditions or a form."
    if block.condition == ALLOCATED and not plan.groups:
        yield ("condition",), "Nobody is allocated: the plan has no groups."
    for name in (block.condition, *block.conditions):
        if name and name != ALLOCATED and name not in plan.conditions:
            yield ("condition" if block.condition else "conditions",), _no_condition(plan, name)
    if len(set(block.conditions)) < len(block.conditions) or len(block.conditions) == 1:
        yield ("conditions",), "conditions lists two or more different ones."
    if block.order != "fixed" and not block.conditions:
        yield ("order",), "An order is of conditions: list them, such as conditions = ['a', 'b']."
    for name, lowest, highest in (("attempts", 1, 200), ("practice", 0, 20), ("rest_s", 0, 600)):
        value = getattr(block, name)
        if value is not None and not lowest <= value <= highest:
            yield (name,), f"{name} is a whole number, {lowest} to {highest}, not {value}."
    if len(block.instructions) > _LONGEST_TEXT:
        yield ("instructions",), _TOO_LONG
    yield from _level_problems(plan, visit, block)


def _level_problems(plan: Study, visit: Visit, block: Block) -> Iterator[Problem]:
    level = block.level
    if isinstance(level, int) and level < 1:
        yield ("level",), f"A level is a whole number from 1 on, not {level}."
    if not isinstance(level, str) or level == OWN:
        return
    earlier = [f"{there.name}/{each.name}" for there, each in plan.blocks() if not each.form]
    this = f"{visit.name}/{block.name}"
    before = earlier[: earlier.index(this)] if this in earlier else []
    if level not in before:
        named = f"It is one of: {', '.join(before)}." if before else "There is none."
        yield (
            ("level",),
            (
                f"A level is a number, {OWN!r}, or an earlier block such as 'first/baseline', not "
                f"{level!r:.60}. {named}"
            ),
        )


def _allocation_problems(plan: Study) -> Iterator[Problem]:
    given = plan.allocation
    total = sum(group.weight for group in plan.groups.values())
    if given.blind and not plan.groups:
        yield ("allocation", "blind"), "Nobody is allocated: the plan has no groups."
    if wrong := [size for size in given.sizes if total and (size < 1 or size % total)]:
        yield ("allocation", "sizes"), f"A size is a multiple of {total}, not {wrong[0]}."
    if not 0.5 < given.certainty <= 1:
        yield ("allocation", "certainty"), "The certainty is above 0.5, and at most 1."
    if given.largest_difference < 1:
        yield ("allocation", "largest_difference"), "The largest difference is 1 or more."
    if given.method == "big stick" and total != 2:
        yield ("allocation", "method"), "The big stick is for two groups of equal weight."
    for name, values in given.strata.items():
        if len(set(values)) < 2:
            yield ("allocation", "strata", name), f"The factor {name} has two values or more."
        if not all(values) or any("|" in value for value in values):
            yield ("allocation", "strata", name), "A value of a factor is a text without |."


def _outcome_problems(plan: Study) -> Iterator[Problem]:
    outcome = plan.outcome
    if outcome is None:
        return
    places = {"outcome": (outcome.visit, outcome.block)}
    if outcome.baseline:
        places["baseline"] = (outcome.baseline.visit, outcome.baseline.block)
    known = {(visit.name, block.name) for visit, block in plan.blocks()}
    for name, place in places.items():
        if place not in known:
            key = ("outcome", name) if name == "baseline" else ("outcome", "block")
            yield key, f"There is no block {place[1]!r} in a visit {place[0]!r}."
    if outcome.compared == "groups, baseline" and not outcome.baseline:
        yield ("outcome", "compared"), "Name the baseline: baseline = { visit = …, block = … }."
    if outcome.compared != "within" and not plan.groups:
        yield ("outcome", "compared"), "The plan has no groups to compare."
    if outcome.compared == "within" and (outcome.visit, outcome.block) in known:
        block = plan.block(outcome.visit, outcome.block)
        compared = outcome.conditions or block.conditions
        if len(compared) != 2 or not set(compared) <= set(block.conditions):
            yield ("outcome", "conditions"), "Name the two conditions that are compared."
    if outcome.is_form and not outcome.measure.endswith(".score"):
        yield (
            ("outcome", "measure"),
            (
                f"The measure is {', '.join(MEASURES)}, or the score of a form such as SUS.score, not "
                f"{outcome.measure!r:.40}."
            ),
        )
    if plan.power:
        try:
            read_power({"power": plan.power}, outcome)
        except StoreError as error:
            named = [name for name in re.findall(r"\w+", str(error)) if name in plan.power]
            yield ("power", *named[:1]), str(error)


# --- orders of conditions


def orders(plan: Study, conditions: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """Return the orders of some conditions between which people differ, so that no order favours a
    condition.

    - ``latin square``: each condition is once at each position.
    - ``williams``: and follows each other one equally often (Williams 1949, Aust J Sci Res A
      2:149-168). With an odd number of conditions there are twice as many rows.
    """
    count = len(conditions)
    first = _zigzag(count) if plan.squares[conditions] == "williams" else range(count)
    square = [[(index + start) % count for index in first] for start in range(count)]
    if plan.squares[conditions] == "williams" and count % 2:
        square += [row[::-1] for row in square]
    return tuple(tuple(conditions[index] for index in row) for row in square)


def _zigzag(count: int) -> list[int]:
    """Return the first row of a Williams design: 0, 1, n-1, 2, n-2, …"""
    return [0, *((at + 1) // 2 if at % 2 else count - at // 2 for at in range(1, count))]
