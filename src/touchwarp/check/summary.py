"""The report in a few plain sentences, for the terminal, the page and the demo's last line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from touchwarp.check.report import join_unit, number_text

if TYPE_CHECKING:
    from touchwarp.check.report import Check, Report

GROUPS = {
    "hard": ("Hard", "what the warp promises; beyond a limit it fails"),
    "judged": ("Judged", "what a person may notice; beyond a limit it warns"),
    "told": ("Told", "for information; no limit"),
}

_VERDICTS = {
    "pass": "This warp keeps every promise",
    "warn": "This warp keeps its promises, with warnings",
    "fail": "This warp breaks a promise",
    "unknown": "Not every promise could be checked",
}


def headline(report: Report) -> str:
    """The verdict in one line."""
    parts = []
    for status, one, many in (
        ("fail", "failure", "failures"),
        ("warn", "warning", "warnings"),
        ("unknown", "unknown", "unknown"),
    ):
        count = len([c for c in report.checks if c.status == status])
        if count:
            parts.append(f"{count} {one if count == 1 else many}")
    held = len([c for c in report.checks if c.group != "told" and c.status == "pass"])
    return f"{_VERDICTS[report.status]}: {held} limits held" + "".join(f", {p}" for p in parts)


def sentences(report: Report) -> list[str]:
    """What was found, in plain words: contact first, then what a person would notice."""
    said = [_contact(report)]
    beside = [c.value or 0.0 for c in report.checks if c.name == "virtual.p99"]
    if beside:
        said.append(
            "Measured to the virtual object's own surface, contact is displayed within "
            f"{join_unit(number_text(max(beside)), 'mm')} at the 99th percentile."
        )
    said += [f"Fails: {_about(c)}." for c in report.with_status("fail")]
    said += [f"Warns: {_about(c)}." for c in report.with_status("warn")]
    felt = _first(report, "budget.gap")
    if felt is not None and felt.value is not None:
        said.append(
            f"With tracking “{report.facts.get('tracking', '')}” a person meets a gap of up to "
            f"{felt.value_text} (95th percentile) between displayed skin and virtual surface."
        )
    return said


def _contact(report: Report) -> str:
    means = [c for c in report.checks if c.name == "contact.mean" and c.value is not None]
    p99s = [c for c in report.checks if c.name == "contact.p99" and c.value is not None]
    if not means or not p99s:
        return "Contact error was not measured."
    mean = max(c.value or 0.0 for c in means)
    p99 = max(c.value or 0.0 for c in p99s)
    worst = " (worst prop)" if len(means) > 1 else ""
    samples = f"{report.facts['touched_samples']:,}".replace(",", "\u202f")
    return (
        "Where the prop is touched the warp misses its goal by "
        f"{join_unit(number_text(mean), 'mm')} on average and "
        f"{join_unit(number_text(p99), 'mm')} at the 99th percentile{worst}, over {samples} points."
    )


def _about(check: Check) -> str:
    title = check.title[0].lower() + check.title[1:]
    subject = f" of {check.subject}" if check.subject else ""
    limit = f", limit {check.limit_text}" if check.limit_text else ""
    return f"{title}{subject} is {check.value_text}{limit}"


def _first(report: Report, name: str) -> Check | None:
    return next((c for c in report.checks if c.name == name), None)
