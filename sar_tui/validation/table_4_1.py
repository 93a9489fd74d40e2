"""Figure 4.8 and Table 4.1 of the thesis: its eight reaches, simulated and measured."""

from collections.abc import Sequence

from sar_tui.motion.detection import detect
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName
from sar_tui.motion.reach import Reach
from sar_tui.motion.samples import Floats
from sar_tui.motion.synthesis import TABLE_4_1, Simulation, TableRow, table_4_1_recording
from sar_tui.validation import charts
from sar_tui.validation.charts import draw_curve
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

RATE_HZ = 250.0
"""Sample rate of the thesis' PhidgetSpatial."""
TIME_MS: dict[DetectorName, float] = {
    "fixed-threshold": 130.0,
    "single-axis": 40.0,
    "orientation": 40.0,
}
"""Largest error of a reach time. The fixed threshold cuts off the slow beginning and end of every
reach.
"""
PEAK_PERCENT = 3.0
_HEADS: dict[DetectorName, str] = {
    "fixed-threshold": "fixed\nthr.",
    "single-axis": "single\naxis",
    "orientation": "orien-\ntation",
}
POINTS_A_SECOND = 50
"""Points of the drawn curve; the file has all samples."""
PEAKS = ("peak_extension", "peak_return")
NOTE = (
    "The thesis measured the times of its table with the fixed-threshold detector, and these "
    "reaches are simulated\n"
    "from them. So the table shows what that detector cuts off, not how long people reach."
)


def simulated_velocity(_: Conditions) -> Report:
    """Return Figure 4.8: the angular velocity about z, one row per sample."""
    simulation = table_4_1_recording(RATE_HZ)
    times, rates = simulation.recording.time_s, simulation.recording.rate[:, 2]
    wrong = []
    for line, (onset, end) in zip(TABLE_4_1, simulation.truth, strict=True):
        inside = rates[(times >= onset) & (times <= end)]
        if not (inside.argmax() < inside.argmin() and inside.max() > 0 > inside.min()):
            wrong.append(line.type)
    rows = velocity_rows(times, rates)
    title = "The eight reaches of Table 4.1, simulated"
    sentence = "Each reach is one large positive spike, followed by one large negative spike."
    return velocity_figure(rows, title, [Claim(sentence, ", ".join(wrong))])


def velocity_rows(times: Floats, rates: Floats) -> list[Row]:
    """Return one row for each sample: time in s, angular velocity in rad/s."""
    return [
        {"time_s": round(float(at), 6), "rate_z_rad_s": float(rate)}
        for at, rate in zip(times, rates, strict=True)
    ]


def velocity_figure(rows: Sequence[Row], title: str, claims: Sequence[Claim]) -> Report:
    """Return a report that draws an angular velocity."""
    step = max(
        1, round(len(rows) / max(1.0, rows[-1]["time_s"] - rows[0]["time_s"]) / POINTS_A_SECOND)
    )
    thinned = rows[::step]
    drawn = draw_curve(
        [row["time_s"] for row in thinned],
        [row["rate_z_rad_s"] for row in thinned],
        title,
        "rad/s about z over s",
    )
    return Report(rows, [], claims, [drawn], chart=charts.angular_velocity(thinned, title))


def run(_: Conditions) -> Report:
    """Return Table 4.1: one row per reach: the table's values, and each detector's."""
    simulation = table_4_1_recording(RATE_HZ)
    found = {name: detect(simulation.recording, name) for name in TIME_MS}
    matched = {name: _matched(simulation, reaches) for name, reaches in found.items()}
    rows = [
        _row(line, {name: reaches[index] for name, reaches in matched.items()})
        for index, line in enumerate(TABLE_4_1)
    ]
    claims = [
        *(_finds_all(name, len(reaches), rows) for name, reaches in found.items()),
        *(_times(name, rows) for name in TIME_MS),
        *(_peaks(name, rows) for name in TIME_MS),
    ]
    return Report(rows, [_times_table(), _peaks_table()], claims, drawings=[NOTE])


def _matched(simulation: Simulation, reaches: tuple[Reach, ...]) -> list[Reach | None]:
    """Return, for each simulated reach, the first one found at its time."""
    return [
        next((reach for reach in reaches if reach.onset_s < end and reach.end_s > onset), None)
        for onset, end in simulation.truth
    ]


def _row(line: TableRow, found: dict[DetectorName, Reach | None]) -> Row:
    row: Row = {
        "type": line.type,
        "table_reach_time_s": line.reach_time_s,
        "table_peak_extension_rad_s": line.peak_extension_rad_s,
        "table_peak_return_rad_s": line.peak_return_rad_s,
    }
    for detector, reach in found.items():
        name = COLUMN_NAMES[detector]
        time_s = None if reach is None else reach.reach_time_s
        row[f"{name}_reach_time_s"] = time_s
        row[f"{name}_difference_ms"] = (
            None if time_s is None else (time_s - line.reach_time_s) * 1000
        )
        for peak in PEAKS:
            value, table = getattr(reach, f"{peak}_rad_s", None), getattr(line, f"{peak}_rad_s")
            row[f"{name}_{peak}_rad_s"] = value
            row[f"{name}_{peak}_difference_percent"] = (
                None if value is None else (value / table - 1) * 100
            )
    return row


def _finds_all(name: DetectorName, count: int, rows: list[Row]) -> Claim:
    column = f"{COLUMN_NAMES[name]}_reach_time_s"
    missed = [str(number) for number, row in enumerate(rows, 1) if row[column] is None]
    against = (
        f"it finds {count}"
        if count != len(rows)
        else f"it misses {', '.join(missed)}"
        if missed
        else ""
    )
    return Claim(f"The {name} detector finds eight reaches.", against)


def _times(name: DetectorName, rows: list[Row]) -> Claim:
    sentence = f"The {name} detector's reach times are within {TIME_MS[name]:g} ms of the table's."
    return Claim(
        sentence, _beyond(rows, f"{COLUMN_NAMES[name]}_difference_ms", TIME_MS[name], "ms")
    )


def _peaks(name: DetectorName, rows: list[Row]) -> Claim:
    against = [
        _beyond(rows, f"{COLUMN_NAMES[name]}_{peak}_difference_percent", PEAK_PERCENT, "%")
        for peak in PEAKS
    ]
    sentence = f"The {name} detector's peaks are within {PEAK_PERCENT:g} % of the table's."
    return Claim(sentence, ", ".join(filter(None, against)))


def _beyond(rows: list[Row], name: str, limit: float, unit: str) -> str:
    wrong = [
        (number, row[name])
        for number, row in enumerate(rows, 1)
        if row[name] is None or abs(row[name]) > limit
    ]
    return ", ".join(
        f"reach {n}: {'none' if value is None else f'{value:+.1f} {unit}'}" for n, value in wrong
    )


def _column(head: str, name: str, form: str) -> Column:
    return Column(head, lambda row: None if row[name] is None else format(row[name], form))


_TYPE = Column("type", lambda row: str(row["type"]), is_number=False)


def _times_table() -> list[Column]:
    columns = [_TYPE, _column("time, s", "table_reach_time_s", ".4f")]
    for name in TIME_MS:
        columns += [
            _column(f"{_HEADS[name]}, s", f"{COLUMN_NAMES[name]}_reach_time_s", ".4f"),
            _column("ms", f"{COLUMN_NAMES[name]}_difference_ms", "+.0f"),
        ]
    return columns


def _peaks_table() -> list[Column]:
    columns = [_TYPE]
    for peak, head in zip(PEAKS, ("out, rad/s", "back, rad/s"), strict=True):
        columns.append(_column(head, f"table_{peak}_rad_s", ".4f"))
        columns += [
            _column(f"{_HEADS[name]}, %", f"{COLUMN_NAMES[name]}_{peak}_difference_percent", "+.2f")
            for name in TIME_MS
        ]
    return columns
