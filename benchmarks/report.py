"""Results as tables in the terminal and on a page, and the machine they were measured on."""

import os
import platform
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table

import sar_tui
from benchmarks import simulate

Results = Mapping[str, Any]
Rows = list[list[str]]

_FIGURES = {
    "n": "trials",
    "mean_ms": "mean",
    "median_ms": "median",
    "sd_ms": "SD",
    "robust_sd_ms": "robust SD",
    "iqr_ms": "IQR",
    "p99_ms": "p99",
    "max_ms": "worst",
}


def machine() -> dict[str, Any]:
    """Describe the machine, without anything that identifies it or its owner."""
    return {
        "system": platform.system(),
        "architecture": platform.machine(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "textual": version("textual"),
        "sar_tui": sar_tui.__version__,
    }


def _processor() -> str:
    """Return the processor's model, if the system reports it."""
    listing = Path("/proc/cpuinfo")
    lines = listing.read_text().splitlines() if listing.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor()


def checks(results: Results) -> dict[str, bool]:
    """Return all checks by name; True if one passed."""
    found: dict[str, bool] = {}
    for name in _TABLES:
        found |= results.get(name, {}).get("checks", {})
    return found


def tables(results: Results) -> dict[str, Rows]:
    """Return the tables of all parts that were measured, by title; the first row is the head."""
    found: dict[str, Rows] = {}
    for name, tabled in _TABLES.items():
        if name in results:
            found |= tabled(results[name])
    checked = [[name, "pass" if ok else "FAIL"] for name, ok in checks(results).items()]
    return found | {"Checks": [["check", "result"], *checked]} if checked else found


def _response(response: Results) -> dict[str, Rows]:
    return {"Recorded minus true reaction time (ms)": _errors(response["programs"])}


def _frames(frames: Results) -> dict[str, Rows]:
    return {
        "Onset of a frame to that of the next, minus its duration (ms)": _errors(frames["programs"])
    }


def _paint(paint: Results) -> dict[str, Rows]:
    medians = [[name, f"{seconds:.3f}"] for name, seconds in paint["median_s"].items()]
    return {
        "Start to first paint (s)": [
            ["program", "median"],
            *medians,
            ["ratio", f"{paint['ratio']:.2f}"],
        ]
    }


def _commands(commands: Results) -> dict[str, Rows]:
    ratios = {name: f"{ratio:.1f}" for name, ratio in commands["ratios"].items()}
    rows = [
        [name, f"{seconds:.3f}", ratios.get(name, "1")]
        for name, seconds in commands["median_s"].items()
    ]
    imported = commands["imports"]["median_s"]
    imports = [
        [name, f"{seconds * 1000:.1f}", f"{seconds / imported['msgspec']:.2f}"]
        for name, seconds in imported.items()
    ]
    return {
        "A command from start to end (s)": [["command", "median", "times Python"], *rows],
        "An import in a new Python (ms)": [["names", "median", "times msgspec"], *imports],
    }


def _flood(flood: Results) -> dict[str, Rows]:
    rows = [
        [kind, f"{one['read_s']:.2f}", f"{one['f1_s']:.3f}"] for kind, one in flood["kinds"].items()
    ]
    return {"A megabyte that nobody types (s)": [["kind", "read", "F1 in the middle"], *rows]}


def _simulate(tasks: Results) -> dict[str, Rows]:
    return {
        "A simulated trial, with the database on": [
            ["task", "trials", "per second", "ms each", "beside it", "ms each", "ratio"],
            *(
                [
                    task,
                    f"{figures['trials']}",
                    f"{figures['trials_per_s']:.0f}",
                    f"{figures['trial_ms']:.3f}",
                    simulate.BESIDE[task],
                    f"{figures['beside_ms']:.3f}",
                    f"{figures['ratio']:.2f}",
                ]
                for task, figures in tasks.items()
            ),
        ]
    }


def _sessions(many: Results) -> dict[str, Rows]:
    few, most = many["sessions"]
    looks = [
        [name, f"{fast:.3f}", f"{slow:.3f}", f"{slow / fast:.2f}"]
        for name, (fast, slow) in many["looks_s"].items()
    ]
    figures = [f"{many['bytes_a_trial']:.0f}", f"{many['trials']}", f"{many['resume_s']:.2f}"]
    return {
        "Lists of sessions of 400 trials (s)": [
            ["", f"{few} sessions", f"{most} sessions", "ratio"],
            *looks,
        ],
        "A long session": [["bytes a trial", "trials", "resume (s)"], figures],
    }


def _export(exported: Results) -> dict[str, Rows]:
    rows = []
    for each in exported["exports"]:
        small, large = each["sizes"]
        memory = [
            f"{size['memory_mb']:.0f}" if size["memory_mb"] else "" for size in (small, large)
        ]
        rows.append(
            [
                f"{large['rows']} {each['what']}",
                each["as"],
                f"{large['s']:.1f}",
                f"{large['rows'] / large['s']:.0f}",
                f"{large['s'] / small['s']:.1f}",
                *memory,
            ]
        )
    head = ["rows", "as", "s", "rows/s", "ratio", "MB of a tenth", "MB"]
    return {"Exports, and those of a tenth of the rows": [head, *rows]}


def _merge(merged: Results) -> dict[str, Rows]:
    return {
        "A merge into a database of as many sessions": [
            [
                "sessions",
                "trials",
                "size (MB)",
                "seconds",
                "CPU's",
                "again, with nothing new",
                "peak memory (MB)",
            ],
            *(
                [
                    f"{size['sessions']}",
                    f"{size['trials']}",
                    f"{size['megabytes']:.0f}",
                    f"{size['merge_s']:.1f}",
                    f"{size['cpu_s']:.1f}",
                    f"{size['again_s']:.1f}",
                    f"{size['memory_mb']:.0f}",
                ]
                for size in merged["sizes"]
            ),
        ]
    }


def _motion(motion: Results) -> dict[str, Rows]:
    return {
        "Analysis of a reach, by all detectors (ms of CPU)": [
            ["samples", "analysis", "six bare transforms", "ratio"],
            [
                f"{motion['samples']:.0f}",
                f"{motion['analyse_ms']:.2f}",
                f"{motion['bare_ms']:.2f}",
                f"{motion['ratio']:.1f}",
            ],
        ],
        "Reaches in a recording at 100 samples a second": [
            ["detector", "hours", "reaches", "found", "CPU's seconds", "peak memory (MB)"],
            *(
                [
                    run["detector"],
                    f"{run['hours']:g}",
                    f"{run['true']}",
                    f"{run['reaches']}",
                    f"{run['cpu_s']:.2f}",
                    f"{run['memory_mb']:.0f}",
                ]
                for run in motion["runs"]
            ),
        ],
    }


_BOUNDARIES = ("onset_ms", "end_ms")
_REACHES = {
    "open": "Reaches of people, in an open stream (median error and p90, ms)",
    "people": "The same, by person and kind of label (ms)",
    "calibrated": "The same, calibrated by each recording's first three, which are not scored (ms)",
    "left out": "The same, each person with the limits (stop, return) that suit the others best (ms)",
    "window": "Reaches of people, each in its known window (ms)",
    "home": "The same, with ends where the hand is back home (ms)",
    "daily": "Daily life of people, who do not reach",
    "simulated": "Simulated reaches (ms)",
}


def _reaches(reaches: Results) -> dict[str, Rows]:
    head = ["movement", "detector", "found", "false/min", "onset, p90", "end, p90"]
    found = {
        title: [head, *(_found(figures) for figures in reaches[part])]
        for part, title in _REACHES.items()
    }
    found["Speed of the hand at the labelled ends of reaches (median)"] = [
        ["person", "rad/s", "share of the way back's largest"],
        *(
            [person, f"{each['rad_s']:.2f}", f"{each['share']:.2f}"]
            for person, each in reaches["still turning"].items()
        ),
    ]
    if watch := reaches["watch"]:
        figures = ("sets", "exact", "within_one")
        found["Sets of 20 repetitions with a watch, counted"] = [
            ["by", "sets", "exact", "within one"],
            *([by, *(str(each[figure]) for figure in figures)] for by, each in watch.items()),
        ]
    found["Found where a reach is asked for, but not sure"] = [
        ["movements", "found", "not sure, so not scored"],
        *([what, *map(str, counted)] for what, counted in reaches["unsure"].items()),
    ]
    return found


def _found(figures: Results) -> list[str]:
    count, false = figures["reaches"], figures["false_a_minute"]
    return [
        figures["kind"],
        figures["detector"],
        f"{figures['found']}/{count}" if count else "",
        "" if false is None else f"{false:.2f}",
        *("{:.0f}, {:.0f}".format(*figures[name]) if figures[name] else "" for name in _BOUNDARIES),
    ]


_MEASURES = {
    "excursion_deg": ("excursion", ".1f"),
    "return_error_deg": ("return error", ".1f"),
    "inclination_rest_deg": ("inclination, rest", ".1f"),
    "inclination_target_deg": ("at the marker", ".1f"),
    "straightness": ("straightness", ".3f"),
    "sparc_out": ("SPARC", ".3f"),
}
_OF_PEOPLE = {
    "sparc": ("SPARC", ".2f"),
    "ldlj_out": ("LDLJ out", ".1f"),
    "ldlj_back": ("LDLJ back", ".1f"),
    "straightness": ("straightness", ".2f"),
    "excursion_deg": ("excursion (°)", ".0f"),
    "reach_time_ms": ("time (ms)", ".0f"),
    "time_to_peak_ms": ("to peak (ms)", ".0f"),
    "movement_units": ("movement units", ".0f"),
}
_BESIDE = {
    "sparc": "SPARC as stored",
    "ldlj": "LDLJ of the speed at 100 samples/s",
    "ldlj, spline": "LDLJ as stored, theirs at 100 samples/s",
    "ldlj, recorded rate": "LDLJ as stored, theirs at the recorded rate",
}


def _measures(measures: Results) -> dict[str, Rows]:
    return _simulated_measures(measures) | _measures_of_people(measures)


def _simulated_measures(measures: Results) -> dict[str, Rows]:
    kinds = measures["kinds"]
    *angles, _, _ = _MEASURES
    errors = {
        title: [
            ["kind", *(_MEASURES[name][0] for name in names)],
            *(
                [kind, *(_several(each[name], _MEASURES[name][1]) for name in names)]
                for kind, each in kinds.items()
            ),
        ]
        for title, names in (
            ("Errors of angles in simulated reaches: median, 95 % (°)", angles),
            (
                "Errors of path and smoothness in these: median, 95 %",
                [name for name in _MEASURES if name not in angles],
            ),
        )
    }
    exact = []
    for name, (label, form) in _MEASURES.items():
        each = measures["exact"][name]
        exact.append([label, f"{each['median']:{form}}", f"{each['most']:{form}}"])
        exact += [
            [f"  except {kind}", "", f"{most:{form}}"] for kind, most in each["except"].items()
        ]
    others = [
        [
            kind,
            str(each["found"]),
            f"{each['other_stop']:.0%}",
            "" if each["other_stop_deg"] is None else f"{each['other_stop_deg']:.1f}",
            f"{each['trunk_deg']:.1f}",
            _several(each["steady_rad_s"], ".3f"),
        ]
        for kind, each in kinds.items()
    ]
    rates = sorted({each["rate_hz"] for each in measures["noise"]})
    noisy: dict[float, list[str]] = {}
    for each in measures["noise"]:
        smooth = f"{each['sparc']:.3f}, {each['ldlj']:.2f}"
        noisy.setdefault(each["noise_deg_s"], []).append(smooth)
    return errors | {
        "Errors over all kinds": [["measure", "median, at most", "95 % within"], *exact],
        "Another stop taken for the target, and the excursion's largest error then (°); largest "
        "error of the trunk's excursion (°); tremor_action_rad_s of a steady hand (median, largest)": [
            ["kind", "found", "other stop", "excursion", "trunk", "steady (rad/s)"],
            *others,
        ],
        "A minimum-jerk way of 1 s: its onset before a share of its peak (ms)": [
            ["share", *measures["begins_ms"]],
            ["before", *(f"{before:.0f}" for before in measures["begins_ms"].values())],
        ],
        "SPARC, LDLJ of a minimum-jerk way of 1 s": [
            ["noise (°/s)", *(f"{rate_hz:.0f} samples/s" for rate_hz in rates)],
            *([f"{noise_deg_s:g}", *cells] for noise_deg_s, cells in noisy.items()),
        ],
        "Minimum-jerk ways by their boundaries: least, largest": [
            ["boundaries", "SPARC", "LDLJ"],
            *(
                [name, _several(each["sparc"], ".3f"), _several(each["ldlj"], ".2f")]
                for name, each in measures["smooth"].items()
            ),
        ],
        "tremor_index of a minimum-jerk reach of 2 rad/s": [
            ["takes (s)", "without tremor", "with 0.15 rad/s at 5 Hz"],
            *(
                [f"{each['takes_s']:g}", f"{each['without']:.3f}", f"{each['with']:.3f}"]
                for each in measures["tremor"]
            ),
        ],
        "Largest error of a reach of 2 s with a bias of 1 °/s (°)": [
            ["detector", *(_MEASURES[name][0] for name in measures["biased_deg"])],
            ["fixed-threshold", *(f"{most:.1f}" for most in measures["biased_deg"].values())],
        ],
    }


def _measures_of_people(measures: Results) -> dict[str, Rows]:
    people = measures["people"]
    return {
        "Reaches of people by manner: median (quartiles)": [
            ["measure", *(f"{manner}, {each['reaches']}" for manner, each in people.items())],
            *(
                [label, *(_quartiles(each[name], form) for each in people.values())]
                for name, (label, form) in _OF_PEOPLE.items()
            ),
        ],
        "Their difference from monalysa (none: it has no such measure)": [
            ["measure", "ways", "median", "largest"],
            *(
                [
                    label,
                    str(measures["monalysa"][name]["ways"]),
                    *(f"{measures['monalysa'][name][figure]:.3f}" for figure in ("median", "most")),
                ]
                for name, label in _BESIDE.items()
            ),
            ["straightness, times", "", "none", "none"],
        ],
    }


def _several(values: Sequence[float], form: str) -> str:
    return ", ".join(f"{value:{form}}" for value in values)


def _quartiles(quartiles: Sequence[float], form: str) -> str:
    low, median, high = (f"{value:{form}}" for value in quartiles)
    return f"{median} ({low}…{high})"


def _sensor(sensor: Results) -> dict[str, Rows]:
    return {
        "A motion sensor's stream, with the session on the screen": [
            [
                "samples per second",
                "seconds",
                "received",
                "lost",
                "CPU",
                "CPU of the sensor's thread",
                "µs per sample",
            ],
            *(
                [
                    f"{run['rate_hz']}",
                    f"{run['seconds']:.0f}",
                    f"{run['samples']}",
                    f"{run['lost']}",
                    f"{run['cpu_share']:.1%}",
                    f"{run['pacing_share']:.1%}",
                    f"{run['per_sample_us']:.1f}",
                ]
                for run in sensor["runs"]
            ),
        ]
    }


def _sensors(sensors: Results) -> dict[str, Rows]:
    return {
        f"Sensors over a line or a network, all at once for {sensors['seconds']:.0f} s": [
            [
                "sensor",
                "samples per second",
                "sent",
                "received",
                "lost",
                "twice",
                "out of order",
                "CPU",
                "sent late by at most (ms)",
            ],
            *(
                [
                    f"{kind}://",
                    *(f"{each[name]}" for name in ("rate_hz", "sent", "received", "lost")),
                    *(f"{each[name]}" for name in ("twice", "out_of_order")),
                    f"{each['cpu_share']:.1%}",
                    f"{each['latest_ms']:.1f}",
                ]
                for kind, each in sensors["kinds"].items()
            ),
        ],
        "Error of the stamps of these sensors, and delay of their arrival (ms)": [
            ["sensor", "error: median", "95%", "99%", "delay: median", "95%", "99%"],
            *(
                [f"{kind}://", *(f"{error:.2f}" for error in each["error_ms"] + each["delay_ms"])]
                for kind, each in sensors["kinds"].items()
            ),
        ],
    }


def _agent(agent: Results) -> dict[str, Rows]:
    return {
        "Stop key to stillness (ms)": [
            ["what", "presses", "median", "worst"],
            *(
                [name, str(figures["n"]), f"{figures['median_ms']:.1f}", f"{figures['max_ms']:.1f}"]
                for name, figures in agent["stops"].items()
            ),
        ],
        "Recorded minus true reaction time (ms), beside the agent": _errors(agent["programs"]),
    }


def _robots(robots: Results) -> dict[str, Rows]:
    figures = ("first_word_ms", "first_word_max_ms", "stop_ms", "stop_max_ms")
    rows = [
        [name, str(found["n"]), *(f"{found[each]:.1f}" for each in figures)]
        for name, found in robots["robots"].items()
    ]
    head = ["robot", "times", "first word, median", "worst", "stop, median", "worst"]
    return {"Request to first word, and stop to the robot's confirmation (ms)": [head, *rows]}


def _operator(operator: Results) -> dict[str, Rows]:
    return {
        "Operator's key to participant's screen (ms)": [
            ["what", "presses", "median", "p99", "worst"],
            *(
                [
                    name,
                    str(figures["n"]),
                    *(f"{figures[each]:.1f}" for each in ("median_ms", "p99_ms", "max_ms")),
                ]
                for name, figures in operator["acts"].items()
            ),
        ],
        "Recorded minus true reaction time (ms), beside an operator": _errors(operator["programs"]),
    }


def _dial_out(visit: Results) -> dict[str, Rows]:
    return {
        "Visitor's key to participant's screen, by what the line adds (ms)": [
            ["line", "acts", "median", "p95", "worst"],
            *(
                [
                    name,
                    str(figures["n"]),
                    *(f"{figures[each]:.1f}" for each in ("median_ms", "p95_ms", "max_ms")),
                ]
                for name, figures in visit["acts"].items()
            ),
        ],
        "Recorded minus true reaction time (ms), beside a visitor": _errors(visit["programs"]),
    }


_TABLES: Mapping[str, Callable[[Results], dict[str, Rows]]] = {
    "response": _response,
    "frames": _frames,
    "paint": _paint,
    "commands": _commands,
    "flood": _flood,
    "simulate": _simulate,
    "sessions": _sessions,
    "export": _export,
    "merge": _merge,
    "motion": _motion,
    "reaches": _reaches,
    "measures": _measures,
    "sensor": _sensor,
    "sensors": _sensors,
    "agent": _agent,
    "robots": _robots,
    "operator": _operator,
    "dial_out": _dial_out,
}


def _errors(programs: Mapping[str, Mapping[str, float]]) -> Rows:
    return [
        ["program", *_FIGURES.values()],
        *(
            [name, *(_number(figures[figure]) for figure in _FIGURES)]
            for name, figures in programs.items()
        ),
    ]


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.3f}"


def drawn(title: str, rows: Rows) -> Table:
    """Return a table for the terminal."""
    table = Table(
        title=title,
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        pad_edge=False,
        title_justify="left",
        title_style="bold",
    )
    for number, name in enumerate(rows[0]):
        table.add_column(name, justify="right" if number else "left", no_wrap=True)
    for row in rows[1:]:
        table.add_row(*row)
    return table


def page(results: Results) -> str:
    """Return the page of the latest results, in Markdown."""
    own = results["machine"]
    lines = [
        "# The latest benchmark",
        "",
        f"{results['measured_at'][:10]}: {own['processor']}, {own['cores']} cores, "
        f"{own['system']}; Python {own['python']}, Textual {own['textual']}, sar-tui "
        f"{own['sar_tui']}. Generated by `make bench`.",
    ]
    for title, (head, *rows) in tables(results).items():
        lines += ["", f"## {title}", "", _line(head), _line(["---", *["---:"] * (len(head) - 1)])]
        lines += [_line(row) for row in rows]
    if "response" in results:
        lines += ["", _quality(results["response"]["quality"])]
    return "\n".join(lines) + "\n"


def _quality(quality: Mapping[str, Any]) -> str:
    """Say what sar-tui itself recorded of its timing."""
    late = (
        f"{quality['handler_delay_ms_median']:.2f} ms (median), "
        f"{quality['handler_delay_ms_max']:.2f} ms (worst)"
    )
    sources = ", ".join(f"{count} × {source}" for source, count in quality["onset_sources"].items())
    return (
        f"As recorded by sar-tui: onset source {sources}; delay from a key's stamp to its "
        f"handler {late}."
    )


def _line(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |".replace("|median|", "\\|median\\|")
