"""``sar-tui study``: a plan, from its first text to the frozen one."""

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.app.command_line import command_line, hint
from sar_tui.cli.common import (
    AsJson,
    Home,
    console,
    named_path,
    print_json,
    write_new,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.study_words import (
    changes,
    commands,
)

if TYPE_CHECKING:
    from sar_tui.study.plan import Study
    from sar_tui.study.rehearsal import Rehearsed

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


def freeze(home: Home, file: PlanFile, key: Key = None) -> None:
    """Freeze a plan before the first enrolment, which otherwise does it."""
    freeze_plan(home, file, key, reason="")


def amend(home: Home, file: PlanFile, reason: Reason = "", key: Key = None) -> None:
    """Freeze a later version of a plan, with the reason for the change."""
    if not reason.strip():
        raise Refused("Say why the plan changes: --reason …")
    freeze_plan(home, file, key, reason=reason.strip())


def freeze_plan(home: Home, file: Path, key: Path | None, *, reason: str) -> None:
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
