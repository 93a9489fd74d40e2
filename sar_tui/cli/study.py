"""``sar-tui study``: people of a study, from enrolment to the tables."""

import sys
from collections.abc import Callable, Sequence
from datetime import UTC, date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.app.command_line import hint
from sar_tui.cli import live, study_plan
from sar_tui.cli.common import (
    AsJson,
    Code,
    Home,
    Markers,
    New,
    Plain,
    SyncFlash,
    are_new,
    named_path,
    print_json,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.live import AllowOperators
from sar_tui.cli.study_plan import (
    Key,
    Reason,
    Which,
    checked_plan,
    freeze_plan,
    key_of,
    study_errors,
)
from sar_tui.cli.study_power import power
from sar_tui.cli.study_words import (
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
    from sar_tui.study.schedule import Next
    from sar_tui.study.status import PersonRow

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)
for name, command in (
    ("new", study_plan.new_study),
    ("check", study_plan.check),
    ("rehearse", study_plan.rehearse),
    ("power", power),
    ("prereg", study_plan.prereg),
    ("freeze", study_plan.freeze),
    ("amend", study_plan.amend),
    ("envelopes", study_plan.envelopes),
):
    app.command(name)(command)


@app.callback()
def study() -> None:
    """Plan a study, enrol people, run what is due, and export it."""


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
            freeze_plan(home, plan, key, reason="")
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
