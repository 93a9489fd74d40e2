"""Declaration of all that is stored: each table once, with the meaning of its columns.

From it are made: the tables of a new database, the rows that follow from the log (`store.rows`),
the check that values are whole (`store.damaged_rows`), the rules of a merge
(`store.merge.foreign_values`), the columns of exports and what may leave (`export.columns`), and the
tables of docs/data-dictionary.md. A new column of an existing table, and a new table, say ``since``
which version of the data; databases of earlier releases get it when they are opened (`store.schema`).
"""

from typing import Literal

import msgspec

FIRST_VERSION = 200
"""Version of the data of the first release, 0.2.0. Unreleased versions of the program wrote others,
from 1 to 22, which are refused (`store.database.version_of`).
"""

Type = Literal["string", "integer", "number", "boolean", "datetime", "json", "blob"]

Privacy = Literal[
    "open", "code", "id", "seed", "time", "clock", "sensor clock", "version", "zone", "text",
    "hash", "person", "device", "place", "parts", "inner",
]  # fmt: skip
"""Treatment of a value when data leaves.

- ``open``: leaves as it is.
- ``code``: a participant's code.
- ``id``: an id of a session or of a record; ``seed``: a seed of what is random.
- ``time``: a date, with or without the time of day.
- ``clock``: one or more stamps of the steady clock of a run; ``sensor clock``: of a sensor's own
  clock. Both go on from session to session, so in a recoded export they count from the run's start,
  or from the first sample.
- ``version``: changes when software or a machine is renewed, and so tells a time. It leaves in a
  recoded export only if all sessions have the same.
- ``zone``: tells the season of a date, and a place. It never leaves in a recoded export.
- ``hash``: of a session's log, which who has the log can find again. Leaves unless the export is
  recoded.
- ``text``: may hold words that a person typed. Leaves only if asked for.
- ``person``, ``device``, ``place``: names a person who is not a participant, a device, or a place
  on a computer or network. Never leaves; a part may say which kind it is.
- ``parts``: JSON, of which parts leave as columns of their own.
- ``inner``: the program's own, of no use elsewhere, or the same in another form. Never leaves.
"""

LEAVING: frozenset[Privacy] = frozenset(
    (
        "open", "code", "id", "seed", "time", "clock", "sensor clock", "version", "zone", "hash",
        "text",
    )
)  # fmt: skip
"""Treatments of values that may leave."""

Form = Literal["line", "note", "word", "seat", "code", "id", "date", "task", "theme", "remark",
               "reason", "site", "record", "kind", "values", "topic", "event", "replacement", "any"]  # fmt: skip
"""Form of a text, to which values from other databases are held (`store.merge.foreign_values`)."""


class Column(msgspec.Struct, frozen=True):
    """A column, or a part of a JSON column.

    Attributes:
        name: in the table; of a part, its path in the JSON, such as ``task.version``.
        meaning: a sentence or less, for codebooks.
        unit: of a number; empty if it has none.
        levels: all values that it can have; empty if they are not known.
        privacy: what becomes of its values when data leaves.
        exported: its name in the export of its table; True: its own, which of a part is the last
            word of its path; False: another table has it, or none.
        required: True if a value is never missing.
        field: in a table whose columns are fields of a message (`store.rows`), the field that it is
            stored from, if that has another name.
        form: of a text that another database may bring.
        sql: constraints and default value, in SQL.
        since: version of the data that added it, for a table that is older. If it is a field of a
            message, ``sql`` has the default of the field: rows of earlier releases get it.
        parts: of JSON, those that are known.
        more: what the data dictionary adds to the meaning, in Markdown.
    """

    name: str
    type: Type
    meaning: str
    unit: str = ""
    levels: tuple[str, ...] = ()
    privacy: Privacy = "open"
    exported: bool | str = True
    required: bool = False
    field: str = ""
    form: Form = "line"
    sql: str = ""
    since: int = FIRST_VERSION
    parts: tuple["Column", ...] = ()
    more: str = ""

    @property
    def leaves(self) -> bool:
        """True if the export of its table has it."""
        return bool(self.exported) and self.privacy in LEAVING

    @property
    def name_in_export(self) -> str:
        """The name of its column in the export of its table."""
        return self.exported if isinstance(self.exported, str) else self.name.rpartition(".")[2]

    @property
    def definition(self) -> str:
        """The column in a CREATE TABLE, or an ALTER TABLE."""
        return f'"{self.name}" {_SQL_TYPES[self.type]} {self.sql}'.rstrip()


_SQL_TYPES = {
    "string": "TEXT", "datetime": "TEXT", "json": "TEXT", "integer": "INTEGER",
    "boolean": "INTEGER", "number": "REAL", "blob": "BLOB",
}  # fmt: skip


class Table(msgspec.Struct, frozen=True):
    """A table.

    Attributes:
        row: what a row is, for people.
        columns: in the order in which people read them. A database that was brought up to date may
            have them in another order, so that statements always name them.
        key: columns that together name a row; empty if nothing does.
        constraints: others than the key, in SQL.
        options: what follows the columns in SQL.
        indexes: SQL of its indexes.
        since: version of the data that added it.
        more: what the data dictionary adds about the table, in Markdown.
    """

    name: str
    row: str
    columns: tuple[Column, ...]
    key: tuple[str, ...] = ()
    constraints: tuple[str, ...] = ()
    options: str = ""
    indexes: tuple[str, ...] = ()
    since: int = FIRST_VERSION
    more: str = ""

    def __getitem__(self, name: str) -> Column:
        """Return a column by its name. Raises KeyError."""
        for column in self.columns:
            if column.name == name:
                return column
        raise KeyError(f"{self.name}.{name}")

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(column.name for column in self.columns)

    def of_type(self, *types: Type) -> tuple[str, ...]:
        """Return the names of the columns of some types."""
        return tuple(column.name for column in self.columns if column.type in types)

    @property
    def create(self) -> str:
        """The statement that creates the table."""
        parts = [column.definition for column in self.columns]
        if self.key:
            parts.append(f"PRIMARY KEY ({', '.join(self.key)})")
        return f"CREATE TABLE {self.name} ({', '.join((*parts, *self.constraints))}) {self.options}"

    def insert(self, *names: str, how: str = "INSERT") -> str:
        """Return the statement that inserts a row of some columns; by default, of all."""
        given = names or self.names
        slots = ",".join("?" for _ in given)
        return f"{how} INTO {self.name} ({', '.join(given)}) VALUES ({slots})"


def _stamp(name: str, meaning: str, *, field: str = "", sql: str = "", more: str = "") -> Column:
    """Return a column of stamps of the session's steady clock."""
    return Column(
        name, "integer", meaning, unit="ns", privacy="clock", field=field, sql=sql, more=more
    )


# --- columns of several tables
# --------------------------------------------------------------------------------------------------

_SESSION = Column("session", "string", "Id of the session.", privacy="id", required=True, form="id")
_SEAT = Column(
    "seat",
    "string",
    "The participant's place: A, or B in a task for two.",
    required=True,
    form="seat",
)
_PARTICIPANT = Column(
    "participant", "string", "Code of the participant.", privacy="code", form="code"
)
_SITE = Column(
    "site",
    "string",
    "Code of the [site](#site) that the row comes from.",
    exported=False,
    form="site",
    sql="NOT NULL DEFAULT ''",
    more="Empty: this one.",
)
_RUN_OF_STAMPS = "The run of the program."


def _not_null(column: Column) -> Column:
    return msgspec.structs.replace(column, sql="NOT NULL")


# --- sessions and their results
# --------------------------------------------------------------------------------------------------

SESSIONS = Table(
    "sessions",
    "A session",
    key=("id",),
    columns=(
        Column(
            "id",
            "string",
            "Id of the session.",
            privacy="id",
            exported="session",
            required=True,
            form="id",
            more="Random text.",
        ),
        Column(
            "mode",
            "string",
            "The session was played by a person (live), by a simulated one, again from a record, "
            "or by an invented person for a demonstration.",
            levels=("live", "simulated", "replayed", "demonstration"),
            required=True,
            form="word",
        ),
        Column("task", "string", "Name of the task.", required=True, form="task"),
        Column("theme", "string", "Name of the agent's theme.", form="theme"),
        Column(
            "status",
            "string",
            "The session had all its attempts (completed), was ended by a person (aborted), was "
            "cut off (interrupted), or was cut off and given up (dismissed). It does not count, "
            "and belongs into no analysis of training, if it was started by mistake (discarded), "
            "or a question that must be agreed to was not (refused).",
            levels=(
                "completed",
                "aborted",
                "interrupted",
                "dismissed",
                "discarded",
                "refused",
            ),
            required=True,
            form="word",
            more="An interrupted one can be resumed, a dismissed one be taken back, a discarded "
            "one be restored; why it was discarded is in its log, under `record/status`. "
            "**Discarded and refused sessions** are in no dose, limits, progress, start levels, "
            "earlier results, visits or reports. A `running` session that no program has locked "
            "was interrupted.",
        ),
        Column("started_at", "datetime", "When it began, UTC.", privacy="time", form="date"),
        Column("ended_at", "datetime", "When it ended, UTC.", privacy="time", form="date"),
        Column("seed", "integer", "Seed of all that is random.", privacy="seed"),
        Column(
            "site",
            "string",
            "Code of the site that recorded it; missing: the site has none.",
            form="site",
            sql="NOT NULL DEFAULT ''",
            more="Empty: this one. Rows of other tables that name the session (`seats`, `trials`, "
            "…) are of its site.",
        ),
        Column(
            "programme",
            "integer",
            "Version of the participant's programme; missing: there was none.",
            more="Of the first participant's, in a task for two.",
        ),
        Column(
            "study",
            "json",
            "The study, and the place of the session in it; missing: it is of none.",
            privacy="parts",
            since=201,
            parts=(
                Column("study", "string", "Name of the study."),
                Column(
                    "version", "integer", "Version of the study's plan.", exported="study_version"
                ),
                Column("visit", "string", "Visit of the study."),
                Column("block", "string", "Block of the visit."),
                Column(
                    "condition",
                    "string",
                    "Condition of the study; of a blind one a neutral code.",
                    exported="study_condition",
                ),
                Column(
                    "position",
                    "integer",
                    "Position of the condition in the person's order, from 1.",
                    exported="order_position",
                ),
            ),
        ),
        Column(
            "parameters",
            "json",
            "Every parameter of the task, also those set for this session only, by `--set`.",
            privacy="parts",
            more="Among them `outputs` (a list of addresses: `screen`, `speech`, `tones`, "
            "`servo…`, `ros://…`), `speech` (`sound`, or `file:` and the folder) and `language`.",
        ),
        Column(
            "software",
            "json",
            "The program, the task and the theme.",
            privacy="parts",
            more="Also the other libraries. A task that is one installed module has the hash of "
            "its file. `task.pictures`: the SHA-256 of each picture in the task's folder, if "
            "there are any.",
            parts=(
                Column(
                    "sar_tui",
                    "string",
                    "Version of sar-tui at the start of the session.",
                    privacy="version",
                ),
                Column("python", "string", "Version of Python.", privacy="version"),
                Column(
                    "packages.numpy",
                    "string",
                    "Version of numpy, by which movements are measured.",
                    privacy="version",
                ),
                Column(
                    "task.title", "string", "The task's name for people.", exported="task_title"
                ),
                Column(
                    "task.version",
                    "string",
                    "Version of the task; results of different versions cannot be compared.",
                    privacy="version",
                    exported="task_version",
                ),
                Column(
                    "task.source",
                    "string",
                    "The task is built in, a user's own, or of an installed package.",
                    privacy="version",
                    exported="task_source",
                ),
                Column(
                    "task.hash",
                    "string",
                    "SHA-256 of the files of the task's folder.",
                    privacy="version",
                    exported="task_sha256",
                ),
                Column(
                    "theme.hash",
                    "string",
                    "SHA-256 of the files of the theme's folder.",
                    privacy="version",
                    exported="theme_sha256",
                ),
                Column(
                    "task.metric.name",
                    "string",
                    "The measure of an attempt.",
                    exported="metric_name",
                ),
                Column("task.metric.unit", "string", "Its unit.", exported="metric_unit"),
                Column(
                    "task.metric.better",
                    "string",
                    "The better results are the lower ones, or the higher ones.",
                    exported="metric_better",
                    levels=("lower", "higher"),
                ),
            ),
        ),
        Column(
            "machine",
            "json",
            "The machine and the terminal.",
            privacy="parts",
            more="`timing`: the figures of `sar-tui timing`, or null.",
            parts=(
                Column("system", "string", "Operating system.", privacy="version"),
                Column("release", "string", "Its version.", privacy="inner"),
                Column("processor", "string", "Architecture of the processor.", privacy="version"),
                Column("cores", "integer", "Number of the processor's cores.", privacy="version"),
                Column(
                    "clock",
                    "string",
                    "The steady clock that stamps are taken from.",
                    privacy="version",
                ),
                Column(
                    "terminal",
                    "string",
                    "Program or kind of the terminal; after `plain, ` if the session was plain lines.",
                    privacy="version",
                ),
                Column("ssh", "boolean", "True if the terminal was connected through SSH."),
                Column(
                    "multiplexer",
                    "string",
                    "The terminal multiplexer that the program ran in; missing: none.",
                ),
                Column(
                    "flags",
                    "string",
                    "Conditions known to make timing less exact, with spaces between them.",
                    exported="timing_flags",
                ),
                Column(
                    "timing.sha256",
                    "string",
                    "The measured timing of the machine in timing.json; missing: not measured.",
                    privacy="version",
                    exported=False,
                ),
            ),
        ),
        Column(
            "log_hash",
            "string",
            "The last hash of the session's log, a running SHA-256.",
            privacy="hash",
            exported="log_sha256",
            form="any",
            sql="NOT NULL DEFAULT ''",
        ),
    ),
)

SEATS = Table(
    "seats",
    "The participant at a seat; trials and attempts of a task for two have a row for each",
    key=("session", "seat"),
    columns=(_SESSION, _SEAT, _PARTICIPANT),
    indexes=('CREATE INDEX "idx_seats_participant" ON "seats" ("participant")',),
)

RUNS = Table(
    "runs",
    "A run of the program on a session",
    key=("session", "run"),
    columns=(
        _SESSION,
        Column("run", "integer", "Number of the run, from 1.", required=True),
        Column(
            "clock_anchor",
            "json",
            "One moment by two clocks.",
            privacy="parts",
            parts=(
                Column(
                    "clock_ns",
                    "integer",
                    "The steady clock at the moment of clock_utc: it relates the stamps of the "
                    "run to the time of day.",
                    unit="ns",
                    privacy="clock",
                ),
                Column(
                    "utc",
                    "datetime",
                    "The time of day at the moment of clock_ns, UTC.",
                    privacy="time",
                    exported="clock_utc",
                ),
                Column(
                    "utc_offset_s",
                    "integer",
                    "Local time minus UTC where the session was played; days of progress are "
                    "counted by it.",
                    unit="s",
                    privacy="zone",
                ),
            ),
        ),
        Column("boot_id", "string", "Which start of the machine it was.", privacy="device"),
        Column("pid", "integer", "Number of the program's process.", privacy="inner"),
        Column(
            "software",
            "json",
            "As in `sessions`, which has that of the first run.",
            privacy="parts",
        ),
        Column("machine", "json", "As in `sessions`: it may be resumed over SSH.", privacy="parts"),
    ),
)

ATTEMPTS = Table(
    "attempts",
    "An attempt at a seat",
    key=("session", "attempt", "seat"),
    columns=(
        _SESSION,
        Column(
            "attempt",
            "integer",
            "Number of the attempt in the session, from 1.",
            required=True,
            more="Practice comes first.",
        ),
        _SEAT,
        Column("run", "integer", "The run of the program in which it ended.", required=True),
        Column("practice", "boolean", "True for practice, which never changes the level."),
        Column("level", "integer", "The level it was done at."),
        Column(
            "condition",
            "string",
            "Its condition; empty in a task without conditions.",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "metric",
            "number",
            "The result; missing without a metric, or if no response could be timed.",
        ),
        Column("metric_unit", "string", "The unit of the result, the goal and the tolerance."),
        Column(
            "goal",
            "number",
            "The goal of the metric; missing if it had none.",
            more="It may differ between levels, and under the difficulty policy `percentile` "
            "between attempts.",
        ),
        Column(
            "accuracy",
            "number",
            "Share of right responses, 0 to 1.",
            more="Of those that are scored: [unsure reaches](movement-measures.md#doubtful-reaches) "
            "are not.",
        ),
        Column("correct", "integer", "Number of right responses."),
        Column("trials", "integer", "Number of prompts."),
        Column(
            "outcome",
            "string",
            "Success: better than the goal, and accurate enough. None: it had no goal, or none of "
            "its trials is sure.",
            levels=("success", "failure", "none"),
            form="word",
        ),
        Column(
            "feedback",
            "string",
            "The feedback that followed; none if none was due or asked for.",
            levels=("positive", "neutral", "negative", "none"),
            form="word",
        ),
        _stamp(
            "started_ns",
            "When it began, steady clock of started_run.",
            field="started",
            more="In an interrupted attempt its start and its end belong to different runs.",
        ),
        _stamp("ended_ns", "Its last response, steady clock of its run.", field="ended"),
        Column(
            "choice",
            "json",
            "The choice of feedback.",
            privacy="parts",
            more="How each schedule decides: [choose feedback](choose-feedback.md). Empty in "
            "sessions of versions that did not store it.",
            parts=(
                Column(
                    "schedule",
                    "string",
                    "The rule that decides when feedback is due.",
                    exported="choice_schedule",
                    more="`every`, `faded`, `bandwidth`, `summary`, `request` or `none`.",
                ),
                Column(
                    "due",
                    "boolean",
                    "True if feedback was due.",
                    exported="choice_due",
                    more="Under `request`: if the participant asked for it.",
                ),
                Column("why", "string", "The reason, in a sentence.", exported="choice_why"),
                Column(
                    "since",
                    "integer",
                    "Scored attempts since the last feedback, including this one.",
                    exported="choice_since",
                ),
                Column(
                    "interval",
                    "integer",
                    "Attempts after which feedback is due.",
                    exported="choice_interval",
                    more="Null if the schedule does not count.",
                ),
                Column(
                    "tolerance",
                    "number",
                    "Largest distance from the goal without feedback, in the metric's unit.",
                    exported="choice_tolerance",
                    more="Null except under `bandwidth`.",
                ),
                Column(
                    "attempts",
                    "integer",
                    "Number of attempts that the feedback sums up.",
                    exported="choice_attempts",
                ),
                Column(
                    "content",
                    "string",
                    "Feedback is about results, performance, or both.",
                    exported="choice_content",
                ),
                Column(
                    "form",
                    "string",
                    "Feedback is qualitative, quantitative, or both.",
                    exported="choice_form",
                ),
                Column(
                    "compared_with",
                    "string",
                    "What the result is compared with.",
                    exported="choice_compared_with",
                    more="`last attempt`, `best attempt`, `session's mean` or `goal`.",
                ),
                Column(
                    "degree",
                    "string",
                    "Distance of the result from the goal.",
                    exported="choice_degree",
                    more="`slight`, `clear` or `strong`.",
                ),
                Column(
                    "delay_ms",
                    "number",
                    "From the end of the attempt to its feedback.",
                    unit="ms",
                    exported="choice_delay_ms",
                ),
            ),
        ),
        Column(
            "qualities",
            "json",
            "Mean over the right trials, or another measure of the attempt.",
            privacy="parts",
            more="A field for each of the task's qualities, and other measures of the task (of "
            "pairs: `won`, `together`, `congruency_effect_ms`).",
        ),
    ),
)

TRIALS = Table(
    "trials",
    "A trial at a seat",
    key=("session", "attempt", "trial", "seat"),
    more="Trials of an attempt that ended early are kept, though the attempt has no row in "
    "`attempts`. A prompt that a pause cancels has no row: it is shown again under the "
    "same number.",
    columns=(
        _SESSION,
        Column(
            "attempt", "integer", "Number of the attempt in the session, from 1.", required=True
        ),
        Column("trial", "integer", "Number of the trial in the attempt, from 1.", required=True),
        _SEAT,
        Column("run", "integer", "The run of the program.", required=True),
        Column("stimulus", "string", "The prompt.", form="note"),
        Column(
            "response",
            "string",
            "The pressed key, or the typed text; missing for a miss.",
            form="note",
        ),
        Column(
            "correct",
            "boolean",
            "True if the response was right.",
            more="As pressed (also for an anticipation), and as marked by a therapist.",
        ),
        _stamp(
            "onset_ns",
            "When the prompt was on the terminal; in the reaching task: movement onset. Steady "
            "clock of the run.",
            field="onset",
            more="Of a prompt with frames, the one from which the reaction time counts (empty if "
            "the trial ended before). Without a reach, the prompt's.",
        ),
        _stamp(
            "response_ns",
            "When the response came; in the reaching task: movement end. Steady clock of the run.",
            field="response_at",
            more="Of pairs that reach: **movement onset**.",
        ),
        Column(
            "reaction_time_ms",
            "number",
            "Response minus onset; in the reaching task: from the go signal to movement onset. "
            "Missing for a miss.",
            unit="ms",
            more="Also for a key before the onset, and a reach without a go signal.",
        ),
        Column(
            "timing",
            "json",
            "Exactness of its times, and reasons to leave it out.",
            privacy="parts",
            parts=(
                Column(
                    "onset_source",
                    "string",
                    "The onset was stamped when its frame was flushed to the terminal, at the "
                    "refresh, or on a virtual clock.",
                    more="`flush`, `refresh` or `virtual`.",
                ),
                Column(
                    "handler_delay_ms",
                    "number",
                    "From the stamp of the key to its handling.",
                    unit="ms",
                ),
                Column(
                    "loop_lag_ms",
                    "number",
                    "Largest lag of the program's event loop while the response was awaited.",
                    unit="ms",
                    more="For a miss, the lag of the time-out.",
                ),
                Column("false_starts", "integer", "Number of keys in the foreperiod."),
                Column("presentation", "integer", "1, or more if pauses cancelled the prompt."),
                Column("foreperiod_ms", "number", "Random wait before the prompt.", unit="ms"),
                Column(
                    "flags",
                    "string",
                    "Reasons to look at the trial twice, with spaces between them; empty: none.",
                    more="`anticipation`, `focus_lost`, `paste`, `unreadable_input` (the terminal "
                    "sent what cannot be read), `repeat_key`, `late_key`, `early_key` (a key "
                    "before the frame from which responses are awaited), `other_seat` (a key or a "
                    "reach out of turn), `skipped`, `onset_refresh`, `no_picture` (the picture "
                    "could not be drawn, and the glyph was), `tone_failed` (a tone was not "
                    "heard), `late_frame` (a frame was seen over 10 ms after its time), "
                    "`unmeasured` (it could not be measured three times; the next flag says why), "
                    "`unsure` (without a mark it is not scored), "
                    "and those of the task, such as "
                    "[those of reaching](movement-measures.md#flags).",
                ),
                Column(
                    "frame_onsets_ns",
                    "string",
                    "When each frame of the prompt was on the terminal, session's clock, with "
                    "spaces between; missing: no frames.",
                    unit="ns",
                    privacy="clock",
                    more="[Frames](write-your-own-task.md#a-prompt-that-changes).",
                ),
                Column(
                    "tone_onsets_ns",
                    "string",
                    "When each tone of the prompt began, session's clock, with spaces between; "
                    "missing: no tones.",
                    unit="ns",
                    privacy="clock",
                    more="[Tones](write-your-own-task.md#tones); of a repeated one the first.",
                ),
                Column(
                    "tone_source",
                    "string",
                    "The onsets of tones are by the clock of the sound card (device), by that of "
                    "the program (host), or virtual.",
                    more="That of the program is less exact.",
                ),
            ),
        ),
        Column("details", "json", "The task's own fields, below.", privacy="parts"),
        Column(
            "data",
            "json",
            "Kept with the prompt by its task.",
            privacy="parts",
            sql="NOT NULL DEFAULT '{}'",
            more="`Stimulus.data`; `{}` for nothing.",
        ),
    ),
)

_ACTION = (
    Column("text", "string", "Text on the screen.", privacy="text"),
    Column("spoken", "string", "Text that is said.", privacy="text"),
    Column("face", "string", "The agent's face."),
    Column("gesture", "string", "The agent's gesture."),
    Column("gaze", "string", "Direction of the agent's gaze."),
    Column("tone", "string", "A tone."),
    Column("valence", "string", "Valence of feedback."),
    Column("degree", "string", "Degree of feedback."),
    Column("evidence", "string", "Changes that feedback reports, each with its MDC95."),
    Column("attempt", "integer", "The attempt it belongs to; missing if to none.", exported=False),
)
_ROLES = ("agent", "operator", "participant", "therapist", "stop", "other")
"""``stop`` is the participant's stop key, ``other`` anybody whose role is not known."""

ACTIONS = Table(
    "actions",
    "An action of the agent, or one that was proposed, and the decision on it",
    key=("session", "id"),
    more="`proposed` and `final` also have `id`, `kind`, `seat`, `joins` (it adds to the "
    "text on the screen), `priority` (higher comes first), `policy` (`queue`, "
    "`interrupt`, `drop`) and `due` (earliest time, ns).",
    columns=(
        _SESSION,
        Column(
            "id",
            "string",
            "Id of the action in its session.",
            exported="action",
            required=True,
            more="The agent's proposals count from `a1` (`a1.gesture`: its gesture, if that is "
            "decided on separately), an operator's own actions from `o1`, changes of level that "
            "need an operator's decision from `l1`.",
        ),
        Column(
            "kind",
            "string",
            "What it is for: greeting, feedback, …; difficulty is a change of level.",
            more="`greeting`, `instruction`, `encouragement`, `feedback`, `rest`, `goodbye`; "
            "`filler` (covers a wait); `gesture` (without words); `difficulty` (a change of level "
            "that needs an operator's decision); `remark` (an operator's own text).",
        ),
        Column(
            "decision",
            "string",
            "Outcome of the decision; missing: undecided when the session ended.",
            levels=("accepted", "edited", "rejected", "initiated", "dropped"),
            form="word",
            more="`edited`: by an operator; `rejected`: an operator vetoed it, or refused the "
            "level; `initiated`: an operator's own.",
        ),
        Column(
            "actor",
            "string",
            "Who decided: `agent`, or the operator by name (`operator.NAME`); if dropped, `agent` "
            "or `stop` (the participant's stop key).",
            privacy="person",
            parts=(Column("role", "string", "Who decided.", exported="decided_by", levels=_ROLES),),
        ),
        Column(
            "mode",
            "string",
            "The mode it was decided in.",
            levels=("autonomous", "veto", "approve", "manual"),
            form="word",
        ),
        Column(
            "ground",
            "string",
            "Ground of the decision.",
            more="`mode` (the agent decides alone), `operator` (an operator's decision or stop "
            "key), `deadline` (nobody decided in time), `no operator` (none was there).",
        ),
        Column(
            "reason",
            "string",
            "Why it was dropped.",
            more="`late` (the session had moved on), `stopped`, `amended` (the attempt was scored "
            "again), `vetoed`, `expired` (the operator's time ran out), `no operator`, `manual` "
            "(only the operator acts, and did not); else empty.",
        ),
        _stamp("proposed_ns", "When it was proposed."),
        _stamp("shown_ns", "When it was first shown on an operator's screen."),
        _stamp("deadline_ns", "When it is decided without an operator."),
        _stamp(
            "decided_ns",
            "When it was decided.",
            more="Without an operator: when the action's turn comes or it is dropped.",
        ),
        _stamp("started_ns", "When the first output started."),
        _stamp(
            "ended_ns",
            "When the last output was done, stopped or failed.",
            more="Text on the screen is done when other text replaces it.",
        ),
        Column(
            "proposed",
            "json",
            "The proposal, below; empty for an operator's own action, and for a change of level "
            "that was dropped without an operator.",
            privacy="parts",
            parts=_ACTION,
        ),
        Column(
            "final",
            "json",
            "The final action, with `decision` and `actor`; empty if nothing was done.",
            privacy="parts",
            parts=(
                Column(
                    "level", "integer", "The level that was decided on.", exported="final_level"
                ),
            ),
        ),
    ),
)

NOTES = Table(
    "notes",
    "A note, or an event mark",
    columns=(
        _SESSION,
        _stamp("at_ns", "When it was written, steady clock of the run."),
        Column(
            "author",
            "string",
            "Who wrote it, by name.",
            privacy="person",
            field="actor",
            parts=(
                Column("role", "string", "Who wrote it.", exported="written_by", levels=_ROLES),
            ),
        ),
        Column("label", "string", "Label of an event mark.", privacy="text"),
        Column("text", "string", "The text.", privacy="text", form="note"),
    ),
    indexes=('CREATE INDEX "idx_notes_session" ON "notes" ("session")',),
)

ANSWERS = Table(
    "answers",
    "An answer to a question between attempts, or another step there",
    key=("session", "number"),
    more="[Steps between attempts](ask-questions.md).",
    columns=(
        _not_null(_SESSION),
        Column(
            "number",
            "integer",
            "Number of the step in its session, from 1.",
            required=True,
            sql="NOT NULL",
        ),
        _not_null(_SEAT),
        Column("run", "integer", "The run of the program.", sql="NOT NULL"),
        Column(
            "attempt",
            "integer",
            "Number of attempts before it, without practice.",
            sql="NOT NULL",
        ),
        Column("step", "string", "Name of the step.", field="name", required=True, sql="NOT NULL"),
        Column(
            "kind",
            "string",
            "What was asked for, or shown.",
            levels=(
                "screen",
                "rest",
                "calibration",
                "number",
                "likert",
                "borg",
                "line",
                "choice",
                "choices",
                "text",
            ),
            required=True,
            form="word",
            sql="NOT NULL",
        ),
        Column(
            "text",
            "string",
            "The question, or what was to be read.",
            form="note",
            sql="NOT NULL",
            more="In the session's language.",
        ),
        Column(
            "labels",
            "json",
            "The options, or the words at the ends of a scale; '; ' between two.",
            sql="NOT NULL",
        ),
        Column(
            "status",
            "string",
            "What came of it; declined: would rather not say.",
            levels=("answered", "declined", "skipped", "done"),
            form="word",
            sql="NOT NULL",
            more="`skipped`: by an operator; `done`: read, or over.",
        ),
        Column(
            "answer",
            "json",
            "The answer; null without one.",
            privacy="parts",
            parts=(
                Column("value", "number", "A point of a scale, or 0 to 100 on a line."),
                Column(
                    "options",
                    "string",
                    "The option, or several with '; ' between two.",
                    exported="chosen",
                ),
                Column("words", "string", "What the participant typed.", privacy="text"),
            ),
        ),
        _stamp(
            "shown_ns",
            "When it was shown, steady clock of the run.",
            field="shown",
            sql="NOT NULL",
            more="After a pause, again.",
        ),
        _stamp(
            "answered_ns",
            "When it was answered or over, same clock.",
            field="ended",
            sql="NOT NULL",
        ),
    ),
)

# --- the log
# --------------------------------------------------------------------------------------------------

_SEQ = Column("seq", "integer", "Number of the message in its session, in order.", required=True)
_RUN_OF_MESSAGE = Column("run", "integer", _RUN_OF_STAMPS, required=True)
_AT = _stamp("at_ns", "When its cause entered the program, steady clock of the run.")

MESSAGES = Table(
    "messages",
    "A message of `events`, as it is stored",
    key=("session_number", "seq"),
    options="WITHOUT ROWID",
    more="Read them by the view [`events`](#events).",
    columns=(
        Column(
            "session_number",
            "integer",
            "The session's number in `session_numbers`.",
            privacy="inner",
            sql="NOT NULL",
        ),
        _not_null(_SEQ),
        _not_null(_RUN_OF_MESSAGE),
        _not_null(_AT),
        Column(
            "topic",
            "integer",
            "The number of the topic and its fields, `topics.id`.",
            privacy="inner",
            sql="NOT NULL",
        ),
        Column(
            "message",
            "json",
            "An array of the values of the fields in `topics`, in that order; values at the end "
            "that are defaults are left out. Messages of `operator/presence`: an object.",
            privacy="text",
            exported=False,
            sql="NOT NULL",
        ),
    ),
    indexes=("CREATE INDEX idx_messages_presence ON messages (session_number, seq) WHERE topic=1",),
)

SESSION_NUMBERS = Table(
    "session_numbers",
    "A session's number in `messages`",
    key=("number",),
    columns=(
        Column("number", "integer", "The number.", privacy="inner"),
        Column("id", "string", "The session's id.", privacy="id", form="id", sql="NOT NULL UNIQUE"),
    ),
)

TOPICS = Table(
    "topics",
    "A topic, and the fields of its messages; a version of sar-tui with other fields adds a row",
    key=("id",),
    constraints=("UNIQUE (name, fields)",),
    columns=(
        Column("id", "integer", "The number of the topic.", privacy="inner"),
        Column(
            "name",
            "string",
            "The topic, which says what it is.",
            exported="topic",
            required=True,
            form="topic",
            sql="NOT NULL",
        ),
        Column(
            "fields",
            "string",
            "JSON: an array of `[name, default]`, or of `[name]` if there is no default; empty if "
            "messages are objects.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
        ),
    ),
)

LOG_HASHES = Table(
    "log_hashes",
    "A group of messages that was stored in one transaction, with its hash",
    key=("session", "number"),
    more="[What the hashes prove](keep-data-safe.md#what-the-hashes-prove).",
    columns=(
        _not_null(_SESSION),
        Column(
            "number",
            "integer",
            "Number of the group in its session, from 1.",
            privacy="inner",
            sql="NOT NULL",
        ),
        Column(
            "seq",
            "integer",
            "The `seq` in `events` of the last message of the group.",
            privacy="inner",
            sql="NOT NULL",
        ),
        Column(
            "beside",
            "string",
            "JSON: what is hashed with the messages.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
            more='`["facts"]` (the session\'s row and seats), `["run", 1]`, `["stream", 1]` (of '
            '`imu_streams`), `["chunk", 1, 2]` (stream and `seq` of `imu_chunks`), `["ended", '
            "time]`; empty if nothing.",
        ),
        Column(
            "hash",
            "string",
            "SHA-256 in hexadecimal digits: of the hash before it, of the hashes of the messages "
            "in order, and of the rows beside them.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
        ),
    ),
)

# --- motion sensors
# --------------------------------------------------------------------------------------------------

_STREAM = Column("stream", "integer", "Number of the stream in its session, from 1.", required=True)

IMU_STREAMS = Table(
    "imu_streams",
    "A motion sensor, from the moment it was attached",
    key=("session", "stream"),
    more="One that was detached and attached again has two rows.",
    columns=(
        _SESSION,
        _STREAM,
        _SEAT,
        Column(
            "part",
            "string",
            "The part of the body with the sensor.",
            levels=("hand", "trunk"),
            form="word",
            sql="NOT NULL DEFAULT 'hand'",
        ),
        Column("run", "integer", _RUN_OF_STAMPS),
        Column(
            "source",
            "string",
            "Its connection: `USB`, a host, `simulated`, a file's name, `session …`.",
            privacy="place",
        ),
        Column("model", "string", "Model of the sensor."),
        Column("serial", "string", "Its serial number.", privacy="device"),
        Column("rate_hz", "number", "Its nominal samples a second.", unit="Hz"),
        Column(
            "rate_range_rad_s",
            "number",
            "Largest angular rate it measures; 0: unknown.",
            unit="rad/s",
        ),
        Column(
            "acceleration_range_m_s2",
            "number",
            "Largest acceleration it measures; 0: unknown.",
            unit="m/s^2",
        ),
        Column(
            "layout",
            "string",
            "JSON: layout of a sample in `imu_chunks.data`, as numpy's `dtype.descr`.",
            privacy="inner",
            form="any",
        ),
        _stamp("attached_ns", "When it was attached, steady clock of the run."),
    ),
)


def _axes(name: str, meaning: str, unit: str) -> Column:
    return Column(name, "number", f"{meaning}, axis {{axis}}.", unit=unit)


IMU_CHUNKS = Table(
    "imu_chunks",
    "A block of a motion sensor's samples",
    key=("session", "stream", "seq"),
    more="All samples of the session are stored, not only those of reaches. In `data`: `at` "
    "(byte 0, int64), `host` (8, int64), `device_ms` (16, float64), and three float32 "
    "each of `acceleration` (24), `rate` (36) and `field` (48); NaN is not measured. y "
    "points along the fingers, z out of the back of the hand.",
    columns=(
        _SESSION,
        _STREAM,
        Column("seq", "integer", "Number of the block in its stream, from 1."),
        Column("n", "integer", "Number of samples."),
        _stamp("t0_ns", "Time of the first sample."),
        _stamp("t1_ns", "Time of the last sample."),
        Column(
            "before_event",
            "integer",
            "The `seq` in `events` of the next event, so that a replay feeds both in order.",
            privacy="inner",
        ),
        _stamp("at_ns", "When the block entered the program."),
        Column("crc32", "integer", "Of `data`.", privacy="inner"),
        Column(
            "data",
            "blob",
            "The samples, 60 bytes each, little-endian.",
            privacy="parts",
            parts=(
                Column(
                    "at",
                    "integer",
                    "When it was measured, steady clock of the run.",
                    unit="ns",
                    privacy="clock",
                    exported="at_ns",
                    required=True,
                ),
                Column(
                    "host",
                    "integer",
                    "When it arrived, same clock.",
                    unit="ns",
                    privacy="clock",
                    exported="host_ns",
                ),
                Column(
                    "device_ms",
                    "number",
                    "The sensor's own clock.",
                    unit="ms",
                    privacy="sensor clock",
                ),
                _axes("acceleration", "Acceleration", "m/s^2"),
                _axes("rate", "Angular rate", "rad/s"),
                _axes("field", "Magnetic field", "gauss"),
            ),
        ),
    ),
)

# --- people
# --------------------------------------------------------------------------------------------------

PARTICIPANTS = Table(
    "participants",
    "A participant of these sessions",
    key=("code",),
    columns=(
        Column(
            "code",
            "string",
            "Code of the participant.",
            privacy="code",
            exported="participant",
            required=True,
            form="code",
            more="Pseudonymous, in capitals; of another site's participant with its code: "
            "`P01@BERN`.",
        ),
        Column(
            "created_at",
            "datetime",
            "When the participant was added, UTC.",
            privacy="time",
            form="date",
        ),
        _SITE,
    ),
)

PROGRAMMES = Table(
    "programmes",
    "A version of a participant's programme for a task",
    key=("participant", "task", "version"),
    more="Added and never changed; the newest [applies](programmes.md) to the next session. "
    "The view `settings` has the newest of each: `participant`, `task`, `parameters`, "
    "`theme`, `updated_at`.",
    columns=(
        _not_null(_PARTICIPANT),
        Column("task", "string", "Name of the task.", required=True, form="task", sql="NOT NULL"),
        Column(
            "version",
            "integer",
            "Version of the programme, from 1.",
            required=True,
            sql="NOT NULL",
        ),
        Column(
            "created_at",
            "datetime",
            "When it was saved, UTC.",
            privacy="time",
            form="date",
            sql="NOT NULL",
        ),
        Column("theme", "string", "Name of the agent's theme.", form="theme", sql="NOT NULL"),
        Column(
            "author",
            "string",
            "Who saved it: by default the login name; empty if it is not known.",
            privacy="person",
            form="reason",
            sql="NOT NULL",
        ),
        Column(
            "reason",
            "string",
            "Why it was saved.",
            privacy="text",
            form="reason",
            sql="NOT NULL",
            more="Empty if none was given.",
        ),
        Column(
            "parameters",
            "json",
            "The values that differ from the defaults.",
            privacy="parts",
            sql="NOT NULL",
        ),
        _SITE,
    ),
)

RECORDS = Table(
    "records",
    "A version of a record of a person; the last one counts",
    key=("id", "version"),
    more="[Records of people](records.md): append-only, also after the end of a session.",
    indexes=(
        "CREATE INDEX idx_records_session ON records (session)",
        "CREATE INDEX idx_records_participant ON records (participant, kind)",
    ),
    columns=(
        Column(
            "id",
            "string",
            "Id of the record.",
            privacy="id",
            exported="record",
            required=True,
            form="record",
            sql="NOT NULL",
            more="Random text, of another site with its code: `3f9c1a@BERN`.",
        ),
        Column(
            "version",
            "integer",
            "1 when it was entered; each correction adds one.",
            required=True,
            sql="NOT NULL",
        ),
        Column(
            "kind",
            "string",
            "Kind of the record.",
            required=True,
            form="kind",
            sql="NOT NULL",
            more="`sar-tui record kinds` lists them.",
        ),
        _not_null(_PARTICIPANT),
        _not_null(_SEAT),
        Column(
            "session",
            "string",
            "Id of the session; missing if it is of none.",
            privacy="id",
            form="id",
        ),
        Column(
            "moment",
            "string",
            "Before or after the session, or in a pause of it; empty without one.",
            form="word",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "at",
            "string",
            "Local date, or date and time, that it is of; in UTC if it was noted as it was told.",
            privacy="time",
            required=True,
            form="date",
            sql="NOT NULL",
        ),
        Column(
            "removed",
            "boolean",
            "True: entered by mistake. It counts no longer.",
            sql="NOT NULL DEFAULT 0",
        ),
        Column(
            "recorded_at",
            "datetime",
            "When this version was recorded, UTC.",
            privacy="time",
            form="date",
            sql="NOT NULL",
        ),
        Column(
            "recorded_by",
            "string",
            "The login name of the user who recorded it; empty: the participant, or the program.",
            privacy="person",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "content",
            "json",
            "The values by the fields of its kind; in an export a row each.",
            privacy="parts",
            form="values",
            sql="NOT NULL",
            parts=(
                Column("field", "string", "The field.", required=True),
                Column("value", "number", "The value, if it is a number."),
                Column("unit", "string", "Unit of the value."),
                Column("option", "string", "The value, if it is one of some options."),
                Column("words", "string", "The value, if it was typed.", privacy="text"),
            ),
        ),
        _SITE,
    ),
)

STUDIES = Table(
    "studies",
    "A version of the plan of a study, as it was frozen",
    key=("name", "version", "site"),
    since=201,
    more="Append-only.",
    columns=(
        Column("name", "string", "Name of the study.", required=True, form="kind", sql="NOT NULL"),
        Column("version", "integer", "Version of the plan.", required=True, sql="NOT NULL"),
        Column(
            "frozen_at", "datetime", "When it was frozen, UTC.", privacy="time", form="date",
            sql="NOT NULL",
        ),
        Column(
            "frozen_by", "string", "The login name of who did.", privacy="person",
            sql="NOT NULL",
        ),
        Column(
            "reason", "string", "Why it differs from the version before; empty of the first one.",
            privacy="text", form="reason", sql="NOT NULL",
        ),
        Column(
            "mode", "string", "A study with people (live), or a rehearsal with simulated ones.",
            levels=("live", "simulated"), form="word", sql="NOT NULL",
        ),
        Column(
            "blind",
            "boolean",
            "True if nobody who works with participants may know the groups.",
            sql="NOT NULL",
        ),
        Column("sha256", "string", "SHA-256 of the plan.", form="any", sql="NOT NULL"),
        Column(
            "commitment", "string",
            "SHA-256 of the key from which the assignments follow; empty: nobody is allocated.",
            form="any", sql="NOT NULL",
        ),
        Column("plan", "string", "The plan, TOML.", privacy="inner", form="any", sql="NOT NULL"),
        Column(
            "conditions", "json",
            "The conditions with the value of every setting.",
            privacy="inner", form="any", sql="NOT NULL",
        ),
        _SITE,
    ),
)  # fmt: skip

# --- the database itself
# --------------------------------------------------------------------------------------------------

SITE = Table(
    "site",
    "The database's own site, such as a clinic: at most one row",
    key=("number",),
    columns=(
        Column("number", "integer", "Always 1.", privacy="inner", sql="CHECK (number=1)"),
        Column(
            "code",
            "string",
            "The site's code. `sar-tui site BERN` sets it; until then all sites are empty.",
            exported=False,
            form="site",
            sql="NOT NULL",
        ),
    ),
)

SAME_PEOPLE = Table(
    "same_people",
    "Codes of one person at two sites, as `sar-tui merge --same` noted them",
    key=("code", "same_as"),
    more="All rows of the person have the code that this database uses, except `programmes`, "
    "which keep their own.",
    columns=(
        Column(
            "code",
            "string",
            "A code in full, such as `P01@BERN`.",
            privacy="code",
            exported=False,
            form="code",
            sql="NOT NULL",
        ),
        Column(
            "same_as",
            "string",
            "The other one.",
            privacy="code",
            exported=False,
            form="code",
            sql="NOT NULL",
        ),
    ),
)

CONFLICTS = Table(
    "conflicts",
    "A version of a record that contradicts another one, which is in its table",
    key=("kind", "key", "digest"),
    more="[What contradicts](merge-data.md#what-contradicts).",
    columns=(
        Column(
            "kind",
            "string",
            "`session`, `programme` or `record`.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
        ),
        Column(
            "key",
            "string",
            "The session's id, or the key of the record in words.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
        ),
        Column(
            "digest",
            "string",
            "SHA-256 of the rows.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
        ),
        Column(
            "content",
            "blob",
            "All rows of the version by table, as MessagePack, packed with zlib.",
            privacy="inner",
            sql="NOT NULL",
        ),
    ),
)

EXPORTS = Table(
    "exports",
    "An export of the [ledger](export-data.md#the-ledger)",
    key=("number",),
    more="Append-only.",
    columns=(
        Column("number", "integer", "Number of the export.", privacy="inner"),
        Column(
            "exported_at", "datetime", "When, UTC.", privacy="inner", form="date", sql="NOT NULL"
        ),
        Column(
            "exported_by",
            "string",
            "The login name of who did.",
            privacy="person",
            sql="NOT NULL",
        ),
        Column(
            "recipient",
            "string",
            "For whom, in words; empty if it was not said.",
            privacy="text",
            exported=False,
            sql="NOT NULL",
        ),
        Column("format", "string", "The form of the files.", privacy="inner", sql="NOT NULL"),
        Column(
            "sessions",
            "string",
            "JSON: the ids of the sessions.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
        ),
        Column(
            "options",
            "string",
            "JSON: `with_notes`, `with_events`, `recoded`.",
            privacy="inner",
            form="any",
            sql="NOT NULL",
        ),
        Column(
            "manifest",
            "string",
            "SHA-256 of `sar-tui-export.json`.",
            privacy="inner",
            sql="NOT NULL",
        ),
        _SITE,
    ),
)

PEOPLE_EVENTS = Table(
    "people_events",
    "A use of a [person's rights](peoples-rights.md): a withdrawal, a de-identification, an erasure",
    key=("id",),
    since=201,
    more="Append-only, except that an erasure removes withdrawals of the person. An `erased` "
    "one is a tombstone: what is of the person does not come back by a merge or a rescue file.",
    columns=(
        Column(
            "id",
            "string",
            "Random text.",
            privacy="inner",
            form="id",
            sql="NOT NULL",
        ),
        Column(
            "event",
            "string",
            "What was done; resumed: a withdrawal was taken back.",
            levels=("withdrawn", "resumed", "de-identified", "erased"),
            privacy="inner",
            form="event",
            sql="NOT NULL",
        ),
        Column(
            "participant",
            "string",
            "Code of the person; of one who was de-identified, the new code.",
            privacy="code",
            exported=False,
            form="code",
            sql="NOT NULL",
        ),
        Column("at", "datetime", "When, UTC.", privacy="inner", form="date", sql="NOT NULL"),
        Column(
            "recorded_by",
            "string",
            "The login name of who recorded it.",
            privacy="person",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "reason",
            "string",
            "Why.",
            privacy="text",
            exported=False,
            form="reason",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "details",
            "json",
            "Of a withdrawal `data` (keep, or exclude from exports, reports and progress) and `on`, its "
            "day. "
            "Of the others `sessions`: the seat of the person in each, by id; `records`: ids.",
            privacy="inner",
            sql="NOT NULL DEFAULT '{}'",
        ),
        Column(
            "replaced_by",
            "string",
            "Of an erasure: the code in sessions for two, of which the partner's part stays.",
            privacy="code",
            exported=False,
            form="replacement",
            sql="NOT NULL DEFAULT ''",
        ),
        _SITE,
    ),
    indexes=("CREATE INDEX idx_people_events_participant ON people_events (participant)",),
)

CORRESPONDENTS = Table(
    "correspondents",
    "A computer with which this one exchanges [sealed letters](train-at-home.md): at a clinic one "
    "at home, at home the clinic's",
    key=("id",),
    since=202,
    columns=(
        Column("id", "string", "Random text.", privacy="inner", form="id", sql="NOT NULL"),
        Column(
            "participant",
            "string",
            "Code of the person who trains at home.",
            privacy="code",
            exported=False,
            form="code",
            sql="NOT NULL",
        ),
        Column(
            "number",
            "integer",
            "At a clinic, number of the person's computer, from 1.",
            privacy="inner",
            sql="NOT NULL DEFAULT 1",
        ),
        Column(
            "state",
            "string",
            "Invited, not heard of yet; joined; revoked; declined: its invitation was used or too "
            "old.",
            levels=("invited", "joined", "revoked", "declined"),
            privacy="inner",
            form="word",
            sql="NOT NULL",
        ),
        Column(
            "verify_key",
            "blob",
            "Public key of its signatures (Ed25519); missing: not known yet.",
            privacy="inner",
        ),
        Column(
            "seal_key",
            "blob",
            "Public key to which letters for it are sealed (Curve25519); missing: not known yet.",
            privacy="inner",
        ),
        Column(
            "invitation",
            "string",
            "SHA-256 of the secret in the invitation.",
            privacy="inner",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "invited_at",
            "datetime",
            "When it was invited, UTC.",
            privacy="inner",
            form="date",
            sql="NOT NULL",
        ),
        Column(
            "expires_at",
            "datetime",
            "Until when the invitation can be used, UTC.",
            privacy="inner",
            form="date",
            sql="NOT NULL",
        ),
        Column(
            "heard_at",
            "datetime",
            "When a letter from it was taken last, UTC; empty: never.",
            privacy="inner",
            form="date",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "least_number",
            "integer",
            "Least number of the next letter to it.",
            privacy="inner",
            sql="NOT NULL DEFAULT 1",
        ),
        Column(
            "owes_answer",
            "integer",
            "1 if it waits to hear what has arrived here, or was looked at.",
            privacy="inner",
            sql="NOT NULL DEFAULT 0",
        ),
        Column(
            "wanted",
            "json",
            "Numbers of its letters that it has to write again.",
            privacy="inner",
            sql="NOT NULL DEFAULT '[]'",
        ),
        Column(
            "void",
            "json",
            "Ranges of numbers of its letters that never come.",
            privacy="inner",
            sql="NOT NULL DEFAULT '[]'",
        ),
        Column(
            "device",
            "json",
            "The computer, as it described itself in its last letter.",
            privacy="inner",
            sql="NOT NULL DEFAULT '{}'",
        ),
        Column(
            "notice",
            "string",
            "What it has to be told in one last letter: `used` or `expired`; empty: nothing.",
            privacy="inner",
            form="word",
            sql="NOT NULL DEFAULT ''",
        ),
    ),
)

LETTERS = Table(
    "letters",
    "A sealed letter to or from a correspondent",
    key=("correspondent", "direction", "number"),
    since=202,
    more="Rows are kept; what was sealed is removed when the other side has it.",
    columns=(
        Column(
            "correspondent",
            "string",
            "Id of the correspondent.",
            privacy="inner",
            form="id",
            sql="NOT NULL",
        ),
        Column(
            "direction",
            "string",
            "To the correspondent (out), or from it (in).",
            levels=("out", "in"),
            privacy="inner",
            form="word",
            sql="NOT NULL",
        ),
        Column(
            "number",
            "integer",
            "From 1, in the order in which they were written.",
            privacy="inner",
            sql="NOT NULL",
        ),
        Column(
            "state",
            "string",
            "Out: sent; acknowledged by the other side, or refused there; void, as another one says "
            "the same. In: taken, or refused.",
            levels=("sent", "acknowledged", "void", "taken", "refused"),
            privacy="inner",
            form="word",
            sql="NOT NULL",
        ),
        Column(
            "at",
            "datetime",
            "When it was written or taken here, UTC.",
            privacy="inner",
            form="date",
            sql="NOT NULL",
        ),
        Column(
            "put_at",
            "datetime",
            "When it was put into the letterbox last, UTC; empty: not yet, or it came from there.",
            privacy="inner",
            form="date",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "seen_at",
            "datetime",
            "When a person looked at what it brought, UTC; empty: not yet.",
            privacy="inner",
            form="date",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "file",
            "string",
            "Name of its file in the letterbox.",
            privacy="inner",
            sql="NOT NULL",
        ),
        Column(
            "digest",
            "string",
            "SHA-256: of one from here as it was sealed, of one from elsewhere as it was opened.",
            privacy="inner",
            sql="NOT NULL",
        ),
        Column(
            "sealed",
            "blob",
            "The letter as it was sealed, until the other side has it.",
            privacy="inner",
        ),
        Column(
            "contents",
            "json",
            "What it brings: by table the rows, each with what it was like.",
            privacy="inner",
            sql="NOT NULL DEFAULT '{}'",
        ),
        Column(
            "reason",
            "string",
            "Why it was refused.",
            privacy="inner",
            form="reason",
            sql="NOT NULL DEFAULT ''",
        ),
    ),
)

LETTER_FILES = Table(
    "letter_files",
    "A file in the letterbox that was looked at and need not be opened again",
    key=("name",),
    since=202,
    columns=(
        Column("name", "string", "Its name.", privacy="inner", sql="NOT NULL"),
        Column("size", "integer", "Its size.", unit="bytes", privacy="inner", sql="NOT NULL"),
        Column(
            "changed_ns",
            "integer",
            "When it was written last, of the computer's clock.",
            unit="ns",
            privacy="inner",
            sql="NOT NULL",
        ),
        Column(
            "refused",
            "string",
            "Why it was refused; empty: it was taken, or is for another computer.",
            privacy="inner",
            form="reason",
            sql="NOT NULL DEFAULT ''",
        ),
        Column(
            "at",
            "datetime",
            "When it was looked at, UTC.",
            privacy="inner",
            form="date",
            sql="NOT NULL",
        ),
    ),
)

TABLES = {
    table.name: table
    for table in (
        PARTICIPANTS,
        SESSIONS,
        SEATS,
        RUNS,
        ATTEMPTS,
        TRIALS,
        ACTIONS,
        NOTES,
        IMU_STREAMS,
        IMU_CHUNKS,
        SESSION_NUMBERS,
        TOPICS,
        MESSAGES,
        PROGRAMMES,
        RECORDS,
        STUDIES,
        EXPORTS,
        SITE,
        SAME_PEOPLE,
        PEOPLE_EVENTS,
        CONFLICTS,
        ANSWERS,
        LOG_HASHES,
        CORRESPONDENTS,
        LETTERS,
        LETTER_FILES,
    )
}
"""All tables, in the order in which they are created."""

VERSION = max(
    max(table.since, *(column.since for column in table.columns)) for table in TABLES.values()
)
"""Version of the data, which is stored in ``PRAGMA user_version``."""


def with_column(name: str) -> tuple[str, ...]:
    """Return the names of the tables that have a column."""
    return tuple(table.name for table in TABLES.values() if name in table.names)


ADDED_LATER = ("records",)
"""Tables with a session that are no part of its record: people add rows later, or before it."""
SESSION_TABLES = tuple(name for name in with_column("session") if name not in ADDED_LATER)
"""Tables whose rows are the record of a session, beside ``sessions`` and ``messages``."""
