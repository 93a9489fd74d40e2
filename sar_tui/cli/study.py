"""``sar-tui study``: a study from its plan to its tables."""

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from datetime import UTC, date, datetime
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.app.command_line import command_line, hint
from sar_tui.cli import live
from sar_tui.cli.common import (
    AsJson,
    Code,
    Home,
    Markers,
    New,
    Plain,
    SyncFlash,
    are_new,
    console,
    named_path,
    print_json,
    write_new,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.live import AllowOperators
from sar_tui.cli.study_power import power
from sar_tui.cli.study_words import (
    changes,
    commands,
    left_words,
    place_words,
    why_stopped,
)

if TYPE_CHECKING:
    import sqlite3

    from sar_tui.study.ledger import Frozen
    from sar_tui.study.next_block import Person
    from sar_tui.study.plan import Study
    from sar_tui.study.rehearsal import Rehearsed
    from sar_tui.study.schedule import Next
    from sar_tui.study.status import PersonRow

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

PlanFile = Annotated[
    Path,
    typer.Argument(
        parser=named_path, metavar="FILE", help="The plan, study.toml.", show_default=False
    ),
]
Which = Annotated[
    str,
    typer.Option(
        "--study", metavar="NAME", show_default=False, help="The study, if there are several."
    ),
]
Key = Annotated[
    Path | None,
    typer.Option(
        "--key",
        parser=named_path,
        metavar="FILE",
        show_default=False,
        help="The file with the study's key. Default: in the user's configuration folder.",
    ),
]
Reason = Annotated[
    str, typer.Option("--reason", metavar="TEXT", show_default=False, help="Why, for the record.")
]


@app.callback()
def study() -> None:
    """Plan a study, enrol people, run what is due, and export it."""


@contextmanager
def study_errors(home: Home | None = None, name: str = "") -> "Iterator[None]":
    """Turn errors of a plan and of the allocation into Refused; of others, complete the command
    that they name.

    Args:
        home: where the command is to work; None if no error names one.
        name: of the study; empty if it was not given, as there is one only.
    """
    from sar_tui.store.database import StoreError
    from sar_tui.study.allocation import AllocationError
    from sar_tui.study.plan import PlanError
    from sar_tui.study.secret import KeyMissing

    try:
        yield
    except KeyMissing as error:
        raise Refused(f"{error} Or name it: --key FILE") from error
    except (PlanError, AllocationError) as error:
        raise Refused(str(error)) from error
    except StoreError as error:
        said = commands(home, name).complete(str(error)) if home else str(error)
        if said == str(error):
            raise
        raise StoreError(said, bad_input=error.bad_input) from error


def key_of(plan: "Study", given: Path | None) -> Path:
    """Return the file of a study's key."""
    from sar_tui.study.secret import key_file

    return given or key_file(plan.name)


def checked_plan(home: Home, file: Path) -> "tuple[str, Study]":
    """Read a plan, and check it with the tasks, themes and forms that are here.

    Raises:
        Refused: it cannot be used.
    """
    from sar_tui.model.toml_lines import TomlLines
    from sar_tui.study.conditions import problems_here
    from sar_tui.study.plan import parse_plan, read_plan

    with study_errors():
        text = read_plan(file)
        plan = parse_plan(text, str(file))
    lines = TomlLines(text, str(file))
    found = [lines.at(key, said) for key, said in problems_here(plan, home.catalogue())]
    if found:
        raise Refused("\n".join(found))
    return text, plan


def _asked(given: str | None, question: str, default: str, check: "Callable[[str], str]") -> str:
    """Return the answer to a question, which is asked again until it can be used, unless it was
    given as an option.

    Raises:
        Refused: the option cannot be used.
    """
    if given is None:
        answer: str = typer.prompt(question, default=default, value_proc=check, err=True)
        return answer
    try:
        return check(given)
    except typer.BadParameter as error:
        raise Refused(str(error)) from error


def _a_name(text: str) -> str:
    from sar_tui.study.plan import NAMED, is_name

    if not is_name(text.strip()):
        raise typer.BadParameter(f"A name {NAMED}, unlike {text.strip()!r:.40}.")
    return text.strip()


def _names(text: str) -> str:
    """Return names of conditions with spaces between them."""
    found = [_a_name(name) for name in text.replace(",", " ").split()]
    if len(set(found)) < 2 or len(set(found)) < len(found):
        raise typer.BadParameter("A study compares two conditions or more, with different names.")
    return " ".join(found)


def _days(text: str) -> str:
    """Return the days of visits with spaces between them."""
    try:
        found = [int(day) for day in text.replace(",", " ").split()]
    except ValueError:
        found = []
    if not found or found[0] != 0 or sorted(set(found)) != found:
        raise typer.BadParameter("Days are numbers in order that begin with 0, such as 0 7 14.")
    return " ".join(map(str, found))


@app.command("new")
def new_study(
    home: Home,
    to: Annotated[
        Path,
        typer.Option("--to", parser=named_path, metavar="FILE", help="The new file."),
    ] = Path("study.toml"),
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", show_default=False, help="Its name: a-z, 0-9, -. All else is asked for."
        ),
    ] = None,
    task: Annotated[
        str | None,
        typer.Option(metavar="TASK", show_default=False, help="The task of all conditions."),
    ] = None,
    conditions: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", show_default=False, help="The conditions, with spaces between them."
        ),
    ] = None,
    within: Annotated[
        bool | None,
        typer.Option(
            "--within/--groups",
            show_default=False,
            help="Each person does all conditions, or is in a group.",
        ),
    ] = None,
    days: Annotated[
        str | None,
        typer.Option(metavar="DAYS", show_default=False, help="Days of the visits, such as 0 7."),
    ] = None,
) -> None:
    """Write a new plan from the answers to five questions."""
    from sar_tui.study.new_plan import new_plan
    from sar_tui.study.plan import parse_plan

    catalogue = home.catalogue()
    tasks = catalogue.task_names()

    def a_task(text: str) -> str:
        from sar_tui.plugins import PluginError

        try:
            return catalogue.task(text.strip()).name
        except PluginError as error:
            raise typer.BadParameter(str(error)) from error

    name = _asked(name, "Name of the study (a-z, 0-9, -)", "my-study", _a_name)
    if task is None:
        print(f"Tasks: {', '.join(tasks)}", file=sys.stderr)
    task = _asked(task, "Task", "keyboard", a_task)
    conditions = _asked(
        conditions, "Conditions, with spaces between them", "praise silence", _names
    )
    if within is None:
        within = typer.confirm("Does each person do all conditions (else: groups)?", err=True)
    days = _asked(days, "Days of the visits, such as 0 7 14; 0: one visit", "0", _days)
    text = new_plan(name, task, conditions.split(), within=within, days=[*map(int, days.split())])
    with study_errors():
        parse_plan(text, str(to))
    write_new(to, text)
    print(hint(f"{to} is written. Change it, then:", f"sar-tui study check {quote(str(to))}"))


@app.command("check")
def check(home: Home, file: PlanFile) -> None:
    """Check a plan: mistakes with their lines; without one, what it plans."""
    from sar_tui.study import ledger
    from sar_tui.study.conditions import warnings
    from sar_tui.study.plan_words import summary

    text, plan = checked_plan(home, file)
    with home.database() as database:
        frozen = ledger.frozen_otherwise(database, plan, text)
    out = console()
    for line in summary(plan):
        out.print(line, soft_wrap=True)
    for warning in (*filter(None, [frozen]), *warnings(plan, home.catalogue())):
        out.print(f"! {warning}", soft_wrap=True)


@app.command("rehearse")
def rehearse(
    home: Home,
    file: PlanFile,
    to: Annotated[
        Path,
        typer.Option(
            "--to", parser=named_path, metavar="DIR", show_default=False, help="A new folder."
        ),
    ],
    people: Annotated[int, typer.Option("--people", min=1, max=500, help="Number of people.")] = 12,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Of all but groups.")] = 1,
    misses: Annotated[
        float, typer.Option("--misses", min=0, max=1, help="Share of visits that are missed.")
    ] = 0.0,
    late: Annotated[
        float, typer.Option("--late", min=0, max=1, help="Share of visits that are late.")
    ] = 0.0,
    leaves: Annotated[
        float, typer.Option("--leaves", min=0, max=1, help="Share who leave after a visit.")
    ] = 0.0,
    as_json: AsJson = False,
) -> None:
    """Let simulated people go through a whole plan, in a folder with a ledger of its own."""
    from sar_tui.cli.progress_line import progress_line
    from sar_tui.drivers.files import make_private
    from sar_tui.study.rehearsal import Habits, monday
    from sar_tui.study.rehearsal import rehearse as run

    text, plan = checked_plan(home, file)
    if to.exists() and any(to.iterdir()):
        raise Refused(f"{to} is not empty: name a new folder.")
    make_private(to)
    with _removed_unless_done(to), study_errors(), progress_line("Rehearsing") as tell:
        found = run(
            plan,
            text,
            home.catalogue(),
            to,
            to / "rehearsal.key",
            people=people,
            seed=seed,
            start=monday(datetime.now(UTC)),
            habits=Habits(misses=misses, late=late, leaves=leaves),
            progress=lambda done, of: tell("Rehearsing", done, of),
        )
    if as_json:
        print_json({"sites": found})
        return
    _print_rehearsed(plan, found)


@contextmanager
def _removed_unless_done(folder: Path) -> "Iterator[None]":
    """Remove a rehearsal that failed, so that it can be tried again in the same folder."""
    from shutil import rmtree

    try:
        yield
    except BaseException:
        rmtree(folder, ignore_errors=True)
        raise


def _print_rehearsed(plan: "Study", found: "Sequence[Rehearsed]") -> None:
    """Print the times of blocks and the forms, in the order of the plan."""
    from statistics import mean

    from sar_tui.cli.tables import Column, Listing, print_listing

    times: dict[tuple[str, str, str], list[float]] = {}
    for site in found:
        for each in site.times:
            times.setdefault((each.visit, each.block, each.condition), []).append(each.seconds)
    filled = _filled_in(plan, found)
    order = [(visit.name, block.name) for visit, block in plan.blocks()]

    def people(row: tuple[str, str, str]) -> int:
        return len(times[row]) if row in times else filled[row[:2]]

    def minutes(row: tuple[str, str, str], of: "Callable[[list[float]], float]") -> str:
        return f"{of(times[row]) / 60:.1f}" if row in times else ""

    forms = [
        (visit.name, block.name, f"form {block.form}")
        for visit, block in plan.blocks()
        if block.form and filled[visit.name, block.name]
    ]
    print_listing(
        Listing(
            "blocks",
            empty="Nobody did a block.",
            columns=(
                Column("visit", lambda row: row[0]),
                Column("block", lambda row: row[1]),
                Column("condition", lambda row: row[2]),
                Column("people", lambda row: str(people(row))),
                Column("minutes", lambda row: minutes(row, mean)),
                Column("longest", lambda row: minutes(row, max)),
            ),
        ),
        sorted([*times, *forms], key=lambda row: (order.index(row[:2]), row[2])),
        False,
    )
    for site in found:
        status_there = command_line(site.folder, (), "study status")
        print(hint(f"{len(site.people)} people:", status_there))


def _filled_in(plan: "Study", found: "Sequence[Rehearsed]") -> "Counter[tuple[str, str]]":
    """Return the number of people who filled in each form, by visit and block."""
    from sar_tui.store.database import connect_to_read
    from sar_tui.study import ledger

    counts: Counter[tuple[str, str]] = Counter()
    for site in found:
        with closing(connect_to_read(site.folder)) as database:
            counts += Counter(
                (each.visit, each.block)
                for each in ledger.played(database, plan.name, "simulated")
                if not each.condition
            )
    return counts


app.command("power")(power)


@app.command("prereg")
def prereg(
    home: Home,
    file: PlanFile,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to", parser=named_path, metavar="FILE", show_default=False, help="A new file."
        ),
    ] = None,
) -> None:
    """Write the preregistration, in the order of AsPredicted's questions."""
    from sar_tui.study.ledger import sha256_of
    from sar_tui.study.plan_words import preregistration

    text, plan = checked_plan(home, file)
    written = preregistration(plan, sha256_of(text))
    if to is None:
        print(written, end="")
    else:
        write_new(to, written)
        print(f"{to} is written.")


@app.command("freeze")
def freeze(home: Home, file: PlanFile, key: Key = None) -> None:
    """Freeze a plan before the first enrolment, which otherwise does it."""
    _freeze(home, file, key, reason="")


@app.command("amend")
def amend(home: Home, file: PlanFile, reason: Reason = "", key: Key = None) -> None:
    """Freeze a later version of a plan, with the reason for the change."""
    if not reason.strip():
        raise Refused("Say why the plan changes: --reason …")
    _freeze(home, file, key, reason=reason.strip())


def _freeze(home: Home, file: Path, key: Path | None, *, reason: str) -> None:
    from sar_tui.drivers.login_name import login_name
    from sar_tui.study import enrolment, ledger

    text, plan = checked_plan(home, file)
    where = key_of(plan, key)
    with home.writable_database() as database, study_errors():
        before = ledger.newest(database, plan.name)
        enrolment.freeze(
            database,
            home.catalogue(),
            text,
            plan,
            where,
            mode="live",
            author=login_name(),
            reason=reason,
        )
        enrolled = ledger.enrolments(database, plan.name)
    print(f"The study {plan.name} is frozen in version {plan.version}.")
    if before and before.plan.version != plan.version:
        for line in changes(before.plan, plan):
            print(f"  {line}")
        if enrolled and enrolment.needs_key(plan):
            print("People who were enrolled before keep their group and their order.")
    if enrolment.needs_key(plan):
        print(f"Its key is {where}. Other sites need a copy; keep it away from the data.")


@app.command("envelopes")
def envelopes(
    home: Home,
    to: Annotated[
        Path,
        typer.Option(
            "--to", parser=named_path, metavar="FILE.html", show_default=False, help="A new file."
        ),
    ],
    number: Annotated[
        int, typer.Option("--number", min=1, max=500, help="Sheets for each stratum.")
    ] = 40,
    name: Which = "",
    key: Key = None,
) -> None:
    """Write numbered sheets for sealed envelopes, for a clinic without a computer at enrolment."""
    from sar_tui.store import sites
    from sar_tui.study import ledger
    from sar_tui.study.enrolment import draws_of
    from sar_tui.study.envelopes import page, sheets

    with home.database() as database, study_errors():
        frozen = ledger.find(database, name)
        draws = draws_of(frozen, key_of(frozen.plan, key))
        if draws is None:
            raise Refused("Nobody is allocated in this study.")
        found = list(sheets(frozen.plan, draws, sites.own(database), number))
    write_new(to, page(frozen.plan, found))
    print(f"{to} has {len(found)} sheets. They tell the groups: seal them, and delete the file.")


@app.command("enrol")
def enrol(
    home: Home,
    participant: Code,
    plan: Annotated[
        Path | None,
        typer.Option(
            "--plan",
            parser=named_path,
            metavar="FILE",
            show_default=False,
            help="The plan, with the first person: it is frozen then.",
        ),
    ] = None,
    factor: Annotated[
        list[str] | None,
        typer.Option(
            "--factor",
            metavar="NAME=VALUE",
            show_default=False,
            help="A factor of the allocation. May be repeated.",
        ),
    ] = None,
    replaces: Annotated[
        str,
        typer.Option(
            "--replaces",
            metavar="CODE",
            show_default=False,
            help="The person who left, whose group and order this one gets.",
        ),
    ] = "",
    listed: Annotated[
        Path | None,
        typer.Option(
            "--list",
            parser=named_path,
            metavar="FILE.csv",
            show_default=False,
            help="A list of groups made elsewhere, with the columns group and stratum.",
        ),
    ] = None,
    name: Which = "",
    key: Key = None,
    new: New = False,
    as_json: AsJson = False,
) -> None:
    """Enrol a person: they come to a group and to an order of conditions."""
    from sar_tui.cli.common import read_settings
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store.participants import check_own
    from sar_tui.study import enrolment, ledger

    code = check_own(participant)
    factors = {k: str(v) for k, v in read_settings(factor, "--factor age=young").items()}
    replaced = check_own(replaces) if replaces else ""
    text, planned = checked_plan(home, plan) if plan else ("", None)
    chosen = name or (planned.name if planned else "")
    with home.writable_database() as database, study_errors(home, chosen):
        wanted = planned or ledger.find(database, name).plan
        if name not in ("", wanted.name):
            raise Refused(f"{plan} is the plan of {wanted.name}, not of {name}.")
        are_new(database, [code], said=new)
        enrolment.check(database, wanted, code, factors=factors, replaces=replaced, listed=listed)
        if plan and not ledger.is_frozen(database, wanted.name, text):
            _freeze(home, plan, key, reason="")
        frozen = ledger.find(database, wanted.name)
        enrolled = enrolment.enrol(
            database,
            frozen,
            code,
            key_of(frozen.plan, key),
            factors=factors,
            replaces=replaced,
            listed=listed,
            author=login_name(),
        )
    if as_json:
        print_json(enrolled)
        return
    group = f" in the group {enrolled.group}" if enrolled.group else ""
    print(f"{code} is number {enrolled.number} of the study {frozen.plan.name}{group}.")
    to = commands(home, frozen.plan.name)
    if frozen.plan.consent:
        agreed = to.command("study consent", code, "--answer", "yes")
        print(hint("When they have agreed to take part:", agreed))
    print(hint("What is due:", to.command("study next", code)))


@app.command("consent")
def consent(
    home: Home,
    participant: Code,
    answer: Annotated[
        str, typer.Option("--answer", metavar="yes|no|withdrawn", show_default=False, help="It.")
    ],
    scope: Annotated[
        list[str] | None,
        typer.Option(
            "--scope",
            metavar="PART",
            show_default=False,
            help="A part that was agreed to, such as video. May be repeated.",
        ),
    ] = None,
    witness: Annotated[
        str,
        typer.Option("--witness", metavar="CODE", show_default=False, help="A witness, as a code."),
    ] = "",
    on: Annotated[
        str,
        typer.Option("--on", metavar="DATE", show_default=False, help="The day. Default: today."),
    ] = "",
    name: Which = "",
) -> None:
    """Record a person's consent to a study, a refusal, or a withdrawal of the consent."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import records
    from sar_tui.store.participants import check_own
    from sar_tui.study import ledger

    code = check_own(participant)
    with home.writable_database() as database, study_errors(home, name):
        plan = ledger.find(database, name).plan
        if plan.consent is None:
            raise Refused(f"The plan of {plan.name} asks for no consent.")
        given = tuple(scope or ())
        if wrong := [part for part in given if part not in plan.consent.scope]:
            known = ", ".join(plan.consent.scope) or "none"
            raise Refused(f"The consent has no part {wrong[0]!r}. Its parts: {known}.")
        if plan.consent.witness and answer == "yes" and not witness:
            raise Refused("This consent needs a witness: --witness CODE")
        content = {
            "study": plan.name,
            "version": plan.consent.version,
            "answer": answer,
            "scope": ", ".join(given),
            "witness": witness,
        }
        kind = records.kind_of(ledger.CONSENT)
        records.add(database, kind, code, on, content, author=login_name())
    said = {"yes": "agreed to", "no": "did not agree to"}.get(answer, "withdrew the consent to")
    print(f"{code} {said} the study {plan.name}, version {plan.consent.version} of its text.")


@app.command("next")
def next_command(
    home: Home,
    participant: Code,
    visit: Annotated[
        str,
        typer.Option(
            "--visit", metavar="NAME", show_default=False, help="Another visit; needs a reason."
        ),
    ] = "",
    block: Annotated[
        str,
        typer.Option(
            "--block", metavar="NAME", show_default=False, help="Another block; needs a reason."
        ),
    ] = "",
    reason: Reason = "",
    show: Annotated[
        bool, typer.Option("--show", help="Say what is due, and begin nothing.")
    ] = False,
    once: Annotated[
        bool, typer.Option("--once", help="Begin one block, not all of today.")
    ] = False,
    name: Which = "",
    key: Key = None,
    operator: AllowOperators = False,
    markers: Markers = None,
    sync_flash: SyncFlash = False,
    plain: Plain = False,
    as_json: AsJson = False,
) -> None:
    """Begin what is due for a person: the next blocks of the visit, one after another."""
    from sar_tui.store.database import StoreError
    from sar_tui.store.participants import check_own

    code = check_own(participant)
    if show or as_json:
        one, found = _due(home, code, name, key, visit, block, reason or "looked at")
        _show_due(one, found, as_json)
        return
    began, stopped = "", ""
    while True:
        try:
            one, found = _due(home, code, name, key, visit, block, reason)
        except StoreError:
            if began:
                break  # nothing more today
            raise
        if began and found.item.visit.name != began:
            break
        how = live.showing(markers, plain=plain, sync_flash=sync_flash, operator=operator)
        name = one.frozen.plan.name  # also if another study is frozen meanwhile
        print(place_words(found.item), file=sys.stderr)
        ended = _begin(home, one, found, reason, how)
        began = found.item.visit.name
        if ended:
            raise typer.Exit(ended)
        with home.database() as database, study_errors(home, name):
            one = _person(database, code, name, key)
        stopped = why_stopped(one, found.item, datetime.now(UTC))
        if once or visit or block or stopped:
            break
        reason = ""
    _print_after(home, one, stopped)


def _due(
    home: Home, code: str, name: str, key: Path | None, visit: str, block: str, reason: str
) -> "tuple[Person, Next]":
    from sar_tui.store.database import StoreError
    from sar_tui.study import next_block

    with home.database() as database, study_errors(home, name):
        one = _person(database, code, name, key)
        _check_place(one.frozen.plan, visit, block)
        try:
            found = next_block.due(
                database, one, datetime.now(UTC), visit=visit, block=block, reason=reason
            )
        except next_block.NeedsReason as needed:
            said = f"{needed} If it is to be now, say why: --reason …"
            raise StoreError(said, bad_input=True) from None
    return one, found


def _person(database: "sqlite3.Connection", code: str, name: str, key: Path | None) -> "Person":
    """Return a person of a study. Raises StoreError, AllocationError."""
    from sar_tui.study import ledger, next_block

    frozen = ledger.find(database, name)
    return next_block.person(database, frozen, code, key_of(frozen.plan, key))


def _show_due(one: "Person", found: "Next", as_json: bool) -> None:
    from sar_tui.study.next_block import in_words

    item = found.item
    if as_json:
        condition = one.names.conditions.get(item.condition, "")
        print_json(
            {
                "participant": one.enrolled.participant,
                "study": one.frozen.plan.name,
                "version": one.frozen.plan.version,
                "visit": item.visit.name,
                "block": item.block.name,
                "condition": condition or None,
                "form": item.block.form or None,
                "position": item.position,
                "state": found.state,
                "resume": found.resume or None,
            }
        )
        return
    goes_on = " It goes on where it was." if found.resume else ""
    print(f"{one.enrolled.participant}: {in_words(one, item)}, {found.state}.{goes_on}")


def _begin(home: Home, one: "Person", found: "Next", reason: str, how: live.Showing) -> int:
    """Begin a block, and return the exit code of its app; 0 if it ended well."""
    from sar_tui.cli.common import checked_settings
    from sar_tui.drivers.login_name import login_name
    from sar_tui.study import next_block

    if found.item.block.form:
        return _fill_form(home, one, found, reason, plain=how.plain)
    if found.resume:
        from sar_tui.runs.run import find_resumable

        with home.database() as database:
            row = find_resumable(database, home.folder, found.resume)
        return live.play_on(home, row, how)
    catalogue = home.catalogue()
    condition = one.frozen.plan.conditions[found.item.condition]
    with home.writable_database() as database:
        with study_errors(), checked_settings(catalogue.task(condition.task)):
            plan = next_block.plan_of(database, catalogue, one, found)
        if plan.task.sensor_seats(plan.parameters):
            live.check_sensor(plan, home)
        next_block.note_deviations(database, one, found, reason, author=login_name())
    return live.play(home, plan, how)


def _fill_form(home: Home, one: "Person", found: "Next", reason: str, *, plain: bool) -> int:
    """Let the person fill in a form, record that it is done, and return the exit code."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import forms
    from sar_tui.store.training_days import utc
    from sar_tui.study import next_block

    kind = forms.form(found.item.block.form)
    of, began = forms.Occasion(one.enrolled.participant), utc()
    with home.writable_database() as database:
        next_block.note_deviations(database, one, found, reason, author=login_name())
    if plain:
        from sar_tui.app.plain import run_plain_form as run
    else:
        from sar_tui.app.app import run_form as run
    ended = run(home.folder, home.catalogue(), kind, of)
    with home.writable_database() as database:
        filled = forms.newest(database, kind, of)
        if filled and filled.recorded_at >= began and forms.is_complete(filled):
            next_block.note_form(database, one, found, filled.id, author=login_name())
    return ended


def _print_after(home: Home, one: "Person", stopped: str) -> None:
    """Say what comes next, after the last block of today.

    Args:
        home: where the study is.
        one: the person.
        stopped: why no more blocks were begun; empty if there are none.
    """
    from sar_tui.study.schedule import visit_days

    plan, code, now = one.frozen.plan, one.enrolled.participant, datetime.now(UTC)
    if stopped:
        print(stopped)
    for day in visit_days(plan, one.items, one.played, now):
        if day.state not in ("done", "missed"):
            left = left_words(code, day, now.astimezone().date())
            if stopped and one.played and one.played[-1].status == "interrupted":
                print(left)  # the app has said how it goes on
            else:
                print(hint(left, commands(home, plan.name).command("study next", code)))
            return
    print(f"{code} has done all of the study {plan.name}.")


@app.command("status")
def status(home: Home, name: Which = "", key: Key = None, as_json: AsJson = False) -> None:
    """Show who has done what: a row a person, a column a visit."""
    from sar_tui.study import ledger
    from sar_tui.study.status import as_of, grid

    with home.database() as database, study_errors():
        frozen = ledger.find(database, name)
        people = ledger.people(database, frozen)
    now = as_of(frozen, people, datetime.now(UTC))
    rows = grid(frozen, people, key_of(frozen.plan, key), now)
    if as_json:
        print_json({"study": frozen.plan.name, "version": frozen.plan.version, "people": rows})
        return
    _print_status(frozen, rows)
    if any(cell.deviated for row in rows for cell in row.visits.values()):
        how = commands(home, frozen.plan.name).command("report study")
        print(hint("! differs from the plan. How, and why:", how))


def _print_status(frozen: "Frozen", rows: "list[PersonRow]") -> None:
    from sar_tui.cli.tables import Column, Listing, print_listing

    def of_visit(visit: str) -> "Callable[[PersonRow], str]":
        return lambda row: row.visits[visit].words.replace(f"due by {date.today()}", "due today")

    visits = tuple(Column(visit.name, of_visit(visit.name)) for visit in frozen.plan.visits)
    print_listing(
        Listing(
            "people",
            empty=f"Nobody is enrolled in the study {frozen.plan.name} yet.",
            columns=(
                Column("who", lambda row: row.participant),
                Column("group", lambda row: row.group),
                *visits,
                Column("deviations", lambda row: str(row.deviations or "")),
                Column("ended", lambda row: row.ended),
            ),
            folds=True,
            whole=("who",),
        ),
        rows,
        False,
    )


@app.command("exit")
def exit_study(
    home: Home,
    participant: Code,
    what: Annotated[
        str,
        typer.Option(
            "--what",
            metavar="withdrawn|excluded|lost|not eligible",
            show_default=False,
            help="How the participation ends.",
        ),
    ] = "withdrawn",
    reason: Reason = "",
    name: Which = "",
) -> None:
    """End a person's participation in a study; what was recorded is kept."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store.participants import check_own
    from sar_tui.study import ledger

    if not reason.strip():
        raise Refused("Say why: --reason …")
    code = check_own(participant)
    with home.writable_database() as database, study_errors(home, name):
        plan = ledger.find(database, name).plan
        enrolled = ledger.enrolment(database, plan.name, code)
        if enrolled.ended and not enrolled.by_consent:
            raise Refused(f"{code} has left the study {plan.name} already: {enrolled.ended}.")
        content = {"what": what, "reason": reason}
        ledger.note(database, ledger.EXIT, plan, code, content, author=login_name())
    print(f"{code} takes part in the study {plan.name} no longer: {what}.")


@app.command("deviation")
def deviation(
    home: Home,
    participant: Code,
    reason: Reason = "",
    visit: Annotated[str, typer.Option("--visit", metavar="NAME", show_default=False)] = "",
    block: Annotated[str, typer.Option("--block", metavar="NAME", show_default=False)] = "",
    name: Which = "",
) -> None:
    """Record that something differed from the plan, such as an interruption from outside."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store.participants import check_own
    from sar_tui.study import ledger

    if not reason.strip():
        raise Refused("Say what differed: --reason …")
    code = check_own(participant)
    with home.writable_database() as database, study_errors(home, name):
        plan = ledger.find(database, name).plan
        ledger.enrolment(database, plan.name, code)
        _check_place(plan, visit, block)
        content = {"visit": visit, "block": block, "what": "other", "reason": reason}
        ledger.note(database, ledger.DEVIATION, plan, code, content, author=login_name())
    print(f"It is recorded for {code}.")


def _check_place(plan: "Study", visit: str, block: str) -> None:
    """Raise Refused if no block of a plan has these names; an empty one is of any name."""
    visits = ", ".join(each.name for each in plan.visits)
    if visit and visit not in [each.name for each in plan.visits]:
        raise Refused(f"There is no visit {visit}. The visits of {plan.name}: {visits}.")
    places = [(there.name, each.name) for there, each in plan.blocks()]
    if block and not any(visit in ("", there) and block == each for there, each in places):
        of_visit = f" in the visit {visit}" if visit else ""
        listed = ", ".join(f"{there}/{each}" for there, each in places if visit in ("", there))
        raise Refused(f"There is no block {block}{of_visit}. There are: {listed}.")


@app.command("reveal")
def reveal(
    home: Home, participant: Code, reason: Reason = "", name: Which = "", key: Key = None
) -> None:
    """Break the code of a person in a blind study: say the group, and record who asked and why."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store.participants import check_own
    from sar_tui.study import ledger

    if not reason.strip():
        raise Refused("A code is broken for a reason only: --reason …")
    code = check_own(participant)
    with home.writable_database() as database, study_errors(home, name):
        one = _person(database, code, name, key)
        plan = one.frozen.plan
        ledger.note(
            database, ledger.CODE_BREAK, plan, code, {"reason": reason}, author=login_name()
        )
    print(f"{code} is in the group {one.names.group(one.enrolled.group)}. It is recorded.")


@app.command("export")
def export(
    home: Home,
    to: Annotated[
        Path,
        typer.Option(
            "--to", parser=named_path, metavar="DIR", show_default=False, help="A new folder."
        ),
    ],
    name: Which = "",
    key: Key = None,
    bids: Annotated[
        bool,
        typer.Option(
            "--bids", help="Also the study's sessions as a BIDS data set, in the folder bids."
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Write the results as two tables, long and wide, with their description."""
    from sar_tui.cli.common import warn_of_git
    from sar_tui.study import ledger, results

    said: list[str] = []
    with home.database() as database, study_errors():
        frozen = ledger.find(database, name)
        played = ledger.played(database, frozen.plan.name, frozen.mode)
        ids = [one.id for one in played if one.condition]  # a form has none
        if bids and frozen.plan.allocation.blind:
            raise Refused(
                f"The study {frozen.plan.name} is blind, and settings of sessions tell the "
                "condition: leave out --bids until it has ended, and is amended with blind = false."
            )
        if bids and not ids:
            raise Refused(f"The study {frozen.plan.name} has no session yet: leave out --bids.")
        written = results.export(database, frozen, to, key_of(frozen.plan, key))
        if bids:
            said = _write_bids(home, database, frozen.plan.name, ids, to / "bids")
            written.append(to / "bids")
    if as_json:
        print_json({"files": [str(path) for path in written], "notices": said})
    else:
        print(f"{', '.join(path.name for path in written)} are in {to}.")
        for sentence in said:
            print(f"! {sentence}", file=sys.stderr)
    warn_of_git(to)


def _write_bids(
    home: Home, database: "sqlite3.Connection", study: str, ids: Sequence[str], to: Path
) -> list[str]:
    """Write the sessions of a study as a BIDS data set, and return sentences on what it lacks."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.export.export import Options
    from sar_tui.export.export import export as write
    from sar_tui.export.registry import load
    from sar_tui.store.selection import Request

    exported = write(
        database,
        home.folder,
        home.catalogue(),
        Request(names=tuple(ids), mixed=True),
        load("bids"),
        to,
        lambda steps: lambda: None,
        Options(author=login_name(), study=study),
    )
    return [*exported.notices, *exported.problems]
