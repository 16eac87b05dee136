"""The certificate: every promise of a warp, checked on this warp."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from touchwarp.outputs import claim, replacing

if TYPE_CHECKING:
    from rich.console import ConsoleOptions, RenderResult

    from touchwarp.check.case import Case

Status = Literal["pass", "warn", "fail", "unknown"]
Group = Literal["hard", "judged", "told"]
Limit = float | tuple[float | None, float | None]

_WORST_FIRST: tuple[Status, ...] = ("fail", "warn", "unknown", "pass")


@dataclass(frozen=True)
class Check:
    """One measured promise.

    Attributes:
        name: a stable key, "family.quantity", such as "contact.p99".
        title: the same for people.
        value: what was measured, in `unit`; None where it could not be.
        unit: "mm", "mm³", "deg", "%", "m⁻²", … or "" for a pure number.
        limit: the greatest value allowed, or (least, greatest) with None for an open end; None
            where there is no limit to hold the value against.
        status: "pass", "warn", "fail", or "unknown" where no known limit fits the conditions.
        group: "hard" checks can fail, "judged" ones warn, "told" ones only inform.
        subject: the prop or fixed surface it is about; "" for the whole warp.
        where: (d,) m, scene frame: where the value was found, or None.
        whole: of what the value is a mean, a sum or a property, so that it has no one place.
        detail: a sentence on how it was measured or what it means.
        condition: under which conditions the limit was found, for limits from studies.
        source: where the limit comes from.
    """

    name: str
    title: str
    value: float | None
    unit: str
    limit: Limit | None
    status: Status
    group: Group
    subject: str = ""
    where: tuple[float, ...] | None = None
    whole: str = ""
    detail: str = ""
    condition: str = ""
    source: str = ""

    @property
    def value_text(self) -> str:
        """The value with its unit; beyond a limit, with as many digits as tell the two apart."""
        if self.value is None:
            return "—"
        digits = 3
        if self.status in ("fail", "warn"):
            limits = self.limit if isinstance(self.limit, tuple) else (self.limit,)
            for limit in limits:
                while limit is not None and digits < 17 and _alike(self.value, limit, digits):
                    digits += 1
        return join_unit(number_text(self.value, digits), self.unit)

    @property
    def limit_text(self) -> str:
        """The limit with its unit, as people write it; "" where there is none."""
        if self.limit is None:
            return ""
        if not isinstance(self.limit, tuple):
            return "≤ " + join_unit(number_text(self.limit), self.unit)
        low, high = self.limit
        if low is None and high is None:
            return ""
        if low is None:
            return "≤ " + join_unit(number_text(high or 0.0), self.unit)
        if high is None:
            return "≥ " + join_unit(number_text(low), self.unit)
        return join_unit(f"{number_text(low)} to {number_text(high)}", self.unit)

    @property
    def where_text(self) -> str:
        """The place in mm, scene frame; "" where there is none."""
        if self.where is None:
            return ""
        return "(" + ", ".join(f"{1e3 * c:.1f}" for c in self.where) + ") mm"

    @property
    def nowhere_text(self) -> str:
        """Why it has no place; "" where it has one."""
        if self.where is not None:
            return ""
        if self.whole:
            return f"No one place: it is {self.whole}."
        if self.value is None:
            return "No place: it was not measured."
        return "No place: it is 0 wherever it was looked for."

    def as_dict(self) -> dict[str, Any]:
        """What the JSON file holds of it: plain values, None for what is not finite."""
        limit = list(self.limit) if isinstance(self.limit, tuple) else self.limit
        return {
            "name": self.name,
            "title": self.title,
            "subject": self.subject,
            "group": self.group,
            "status": self.status,
            "value": _finite(self.value),
            "unit": self.unit,
            "limit": limit,
            "where_m": None if self.where is None else [_finite(c) for c in self.where],
            "detail": self.detail,
            "condition": self.condition,
            "source": self.source,
        }


@dataclass(frozen=True)
class Report:
    """What `check` found.

    Attributes:
        checks: in the order in which people should read them.
        facts: what was checked and how: seed, numbers of samples, seconds, version, λ, tolerance.
        shown: by check family, the arrays that the page draws; not part of the JSON file.
        case: what was checked; not part of the JSON file.
    """

    checks: tuple[Check, ...]
    facts: Mapping[str, Any]
    shown: Mapping[str, Any] = field(default_factory=dict, repr=False, compare=False)
    case: Case | None = field(default=None, repr=False, compare=False)

    @property
    def status(self) -> Status:
        """ "fail" where a hard check fails, else "warn" where a judged one warns, else "pass".

        A hard check that could not be made ("unknown") makes the whole "unknown", unless
        something fails.
        """
        if any(c.status == "fail" for c in self.checks):
            return "fail"
        if any(c.status == "unknown" and c.group == "hard" for c in self.checks):
            return "unknown"
        return "warn" if any(c.status == "warn" for c in self.checks) else "pass"

    def of(self, name: str, subject: str | None = None) -> Check:
        """The check of this name (and subject); the worst of several.

        Raises:
            KeyError: there is none.
        """
        found = [
            c for c in self.checks if c.name == name and (subject is None or c.subject == subject)
        ]
        if not found:
            names = ", ".join(sorted({c.name for c in self.checks}))
            raise KeyError(f"The report has no check {name!r} for {subject!r}; it has {names}.")
        return min(found, key=lambda c: (_WORST_FIRST.index(c.status), -_strain(c)))

    def with_status(self, *statuses: Status) -> tuple[Check, ...]:
        """The checks of any of these statuses."""
        return tuple(c for c in self.checks if c.status in statuses)

    def as_dict(self) -> dict[str, Any]:
        """What `save_json` writes."""
        return {
            "format": "touchwarp certificate",
            "format_version": 1,
            "status": self.status,
            "facts": dict(self.facts),
            "checks": [c.as_dict() for c in self.checks],
        }

    def save_json(self, path: str | PathLike[str]) -> Path:
        """Write the checks as JSON.

        Raises:
            OutputError: `path` cannot be written.
        """
        output = claim(Path(path))
        text = json.dumps(self.as_dict(), indent=1, ensure_ascii=False, allow_nan=False)
        with replacing(output) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")
        return output

    def save_html(self, path: str | PathLike[str]) -> Path:
        """Write one self-contained page with pictures.

        Raises:
            OutputError: `path` cannot be written.
        """
        from touchwarp.check.page import render

        output = claim(Path(path))
        text = render(self)
        with replacing(output) as temporary:
            temporary.write_text(text, encoding="utf-8")
        return output

    def print(self) -> None:
        """Show the checks in the terminal."""
        from rich.console import Console

        Console().print(self)

    def __rich_console__(self, console: ConsoleOptions, options: ConsoleOptions) -> RenderResult:
        from touchwarp.check.terminal import lines

        yield from lines(self, options.max_width)


def measured(
    name: str,
    title: str,
    value: float,
    unit: str = "",
    *,
    limit: Limit | None = None,
    group: Group = "hard",
    **more: Any,
) -> Check:
    """A check whose status follows from its value: beyond the limit, hard ones fail, others warn.

    A value that is not finite is beyond every limit. Without a limit, judged checks are "unknown"
    and told ones pass.
    """
    value = float(value)
    if value == 0.0:
        more["where"] = None  # nothing is nowhere in particular
    low, high = limit if isinstance(limit, tuple) else (None, limit)
    status: Status
    if limit is None and group != "told":
        status = "unknown"
    elif not math.isfinite(value) or _beyond(value, low, high):
        status = "fail" if group == "hard" else "warn"
    else:
        status = "pass"
    return Check(name, title, value, unit, limit, status, group, **more)


def unmeasured(
    name: str, title: str, unit: str = "", *, group: Group = "hard", **more: Any
) -> Check:
    """A check that could not be made; its `detail` should say why."""
    return Check(name, title, None, unit, None, "unknown", group, **more)


def place(points: Any, index: Any) -> tuple[float, ...]:
    """Row `index` of (n, d) points as the plain tuple that `Check.where` wants."""
    return tuple(float(c) for c in points[int(index)])


def number_text(value: float, digits: int = 3) -> str:
    """So many significant digits, whole numbers from 1000 up with thin spaces."""
    if not math.isfinite(value):
        return "not finite"
    size = abs(value)
    if value == 0.0:
        return "0"
    if size >= 1000.0 and size < 1e7:
        return f"{value:,.0f}".replace(",", "\u202f")
    if size < 1e-4 or size >= 1e7:
        mantissa, exponent = f"{value:.{digits - 2}e}".split("e")
        return f"{mantissa}·10{_raised(int(exponent))}"
    return f"{value:.{digits}g}"


def _alike(value: float, limit: float, digits: int) -> bool:
    return number_text(value, digits) == number_text(limit, digits)


def join_unit(number: str, unit: str) -> str:
    """The number and its unit, with a no-break space unless the unit is a degree sign."""
    if not unit:
        return number
    return number + ("°" if unit == "deg" else f"\u202f{unit}")


def worst(checks: Iterable[Check]) -> Status:
    """The worst status among some checks."""
    return min((c.status for c in checks), key=_WORST_FIRST.index, default="pass")


def _strain(check: Check) -> float:
    """The value over its limit; without one, its size."""
    value = math.inf if check.value is None else check.value
    low, high = check.limit if isinstance(check.limit, tuple) else (None, check.limit)
    if high:
        return value / high
    return low / max(value, 1e-300) if low else abs(value)


def _raised(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _beyond(value: float, low: float | None, high: float | None) -> bool:
    return (low is not None and value < low) or (high is not None and value > high)


def _finite(value: float | None) -> float | None:
    return value if value is None or math.isfinite(value) else None
