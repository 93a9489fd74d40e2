"""Figure 4.8 of the thesis: the angular velocity about z in the eight reaches of its Table 4.1, as
simulated.
"""

from collections.abc import Sequence

from sar_tui.motion.samples import Floats
from sar_tui.motion.synthesis import TABLE_4_1, table_4_1_recording
from sar_tui.validation import charts
from sar_tui.validation.charts import draw_curve
from sar_tui.validation.report import Claim, Conditions, Report, Row
from sar_tui.validation.table_4_1 import RATE_HZ

POINTS_A_SECOND = 50
"""Points of the drawn curve; the file has all samples."""


def run(_: Conditions) -> Report:
    """Return one row per sample."""
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
    return figure(rows, title, [Claim(sentence, ", ".join(wrong))])


def velocity_rows(times: Floats, rates: Floats) -> list[Row]:
    """Return one row for each sample: time in s, angular velocity in rad/s."""
    return [
        {"time_s": round(float(at), 6), "rate_z_rad_s": float(rate)}
        for at, rate in zip(times, rates, strict=True)
    ]


def figure(rows: Sequence[Row], title: str, claims: Sequence[Claim]) -> Report:
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
