"""``sar-tui themes``: lists, creates and checks themes."""

import json
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.scaffold import installed
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.checks.theme import Report

app = typer.Typer(rich_markup_mode=None)


@app.callback(invoke_without_command=True)
def list_themes(
    context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None
) -> None:
    """List the themes: how the agent looks and speaks; create or check one."""
    context.obj = home = Home.of(context, data, tasks)
    if context.invoked_subcommand is not None:
        return
    catalogue = home.catalogue()
    rows, broken = installed(
        catalogue.theme_names(),
        catalogue.theme,
        lambda theme: {
            "title": theme.title,
            "languages": theme.languages,
            "summary": theme.summary,
            "repairs": theme.repairs,
        },
    )
    from sar_tui.cli.tables import Column, Listing, print_listing

    print_listing(
        Listing(
            "themes",
            empty="There are no themes.",
            columns=(
                Column("name", itemgetter("name")),
                Column("title", itemgetter("title")),
                Column("languages", lambda row: ", ".join(row["languages"])),
                Column("summary", itemgetter("summary")),
            ),
            folds=True,
            whole=("name",),
        ),
        [*rows, *broken] if as_json else rows,
        as_json,
    )
    if as_json:
        return
    out = console()
    for row in rows:
        if row["repairs"]:
            words = (
                f"! {row['name']} has problems, so replacements are used: sar-tui themes "
                f"check {row['name']}"
            )
            out.print(words, markup=False, soft_wrap=True)
    for problem in broken:
        out.print(f"✗ {problem['error']}", markup=False, soft_wrap=True)


@app.command("new")
def new_theme(
    context: typer.Context,
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="Its name in small letters, such as evening.", show_default=False
        ),
    ],
    model: Annotated[
        str, typer.Option("--from", metavar="THEME", help="The theme to copy.")
    ] = "calm",
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="Folder to create it in. Default: your themes folder.",
        ),
    ] = None,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Create a theme as a copy of another."""
    from sar_tui.checks.task_translations import all_texts, translated
    from sar_tui.checks.theme import missing
    from sar_tui.cli.scaffold import new_theme as create
    from sar_tui.plugin_loader import user_folder

    own = user_folder() / "themes"
    catalogue = Home.of(context, data, tasks).catalogue()
    folder = create(name, to or own, model, catalogue)
    found = folder.parent == own.resolve()
    hint = "" if found else f"\nTo choose it in a session, move it to {own}."
    console().print(
        f"Created {folder}, a copy of {model}. Edit its files, then try\n"
        f"  sar-tui themes check {name if found else folder}{hint}",
        markup=False,
        soft_wrap=True,
    )
    for language, texts in missing(
        folder, all_texts(catalogue), partial(translated, catalogue)
    ).items():
        console().print(
            f"! In {language}, {len(texts)} texts of the screens are shown in English, unless "
            f"words.{language}.toml "
            "translates them. The check lists them.",
            markup=False,
            soft_wrap=True,
        )


@app.command("check")
def check_theme(
    context: typer.Context,
    theme: Annotated[
        str,
        typer.Argument(
            metavar="THEME", help="The theme's name, or its folder.", show_default=False
        ),
    ],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Test a theme: every wording in every language, contrast, faces, gestures."""
    from sar_tui.checks.task_translations import all_texts, translated
    from sar_tui.checks.theme import check

    catalogue = (home := Home.of(context, data, tasks)).catalogue()
    report = check(_folder(theme, home), all_texts(catalogue), partial(translated, catalogue))
    if as_json:
        rows = [
            {"check": c.check, "ok": c.ok, "problems": c.problems, "found": c.found}
            for c in report.checks
        ]
        print_json(
            {
                "theme": report.theme,
                "passed": report.passed,
                "languages": report.languages,
                "checks": rows,
                "contrasts": report.contrasts,
                "english": report.english,
                "missing": report.missing,
            }
        )
    else:
        _print(report)
    if not report.passed:
        raise typer.Exit(FAILED)


def _folder(theme: str, home: Home) -> Path:
    """Return the folder of a theme, given that or its name. Raises Refused."""
    path = named_path(theme).resolve()
    if (path / "theme.toml").is_file():
        return path
    catalogue = home.catalogue()
    if theme in catalogue.theme_names():
        return catalogue.theme_folder(theme)
    if path.is_dir():
        return path
    raise Refused(
        f"There is no theme or folder {theme}. Choose one of: {', '.join(catalogue.theme_names())}."
    )


def _print(report: "Report") -> None:
    out = console()
    for check in report.checks:
        found = f" ({check.found})" if check.found else ""
        out.print(f"{'✓' if check.ok else '✗'} {check.check}{found}", markup=False, soft_wrap=True)
        for problem in check.problems:
            out.print(f"    {problem}", markup=False, soft_wrap=True)
    for language, texts in report.missing.items():
        out.print(
            f"! has the texts of the screens in {language}. These {len(texts)} are shown in "
            "English, unless "
            f"words.{language}.toml translates them:",
            markup=False,
            soft_wrap=True,
        )
        for text in texts:
            line = f'    {json.dumps(text, ensure_ascii=False)} = ""'
            out.print(line, markup=False, highlight=False, soft_wrap=True)
    if report.passed:
        out.print(f"{report.theme} passes all checks.", markup=False)
