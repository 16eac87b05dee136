"""The report: statuses, texts, the JSON file and the terminal."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace

import pytest
from rich.console import Console

import touchwarp as tw
from tests.check.stand_ins import ball_bricks, ball_scene, ball_table, ball_warp, shifted
from touchwarp.check.report import Check, Report, measured, number_text, place, unmeasured, worst
from touchwarp.check.summary import headline, sentences


def one(status="pass", group="hard", **more) -> Check:
    return Check("a.b", "A", 1.0, "mm", 2.0, status, group, **more)


@pytest.mark.parametrize(
    ("value", "limit", "group", "status"),
    [
        (1.0, 2.0, "hard", "pass"),
        (3.0, 2.0, "hard", "fail"),
        (3.0, 2.0, "judged", "warn"),
        (0.8, (0.88, 1.07), "judged", "warn"),
        (1.0, (0.88, 1.07), "judged", "pass"),
        (0.8, (0.88, None), "judged", "warn"),
        (1.0, None, "judged", "unknown"),
        (1.0, None, "told", "pass"),
        (math.nan, 2.0, "hard", "fail"),
        (math.inf, 2.0, "judged", "warn"),
    ],
)
def test_the_status_follows_from_value_and_limit(value, limit, group, status) -> None:
    assert measured("n", "t", value, "mm", limit=limit, group=group).status == status


@pytest.mark.parametrize(
    ("checks", "status"),
    [
        ([one()], "pass"),
        ([one(), one("warn", "judged")], "warn"),
        ([one("fail"), one("warn", "judged")], "fail"),
        ([one("unknown", "judged")], "pass"),
        ([one("unknown"), one("warn", "judged")], "unknown"),
    ],
)
def test_the_verdict_is_that_of_the_hard_checks_then_the_judged(checks, status) -> None:
    assert Report(tuple(checks), {}).status == status


def test_of_finds_the_worst_of_several() -> None:
    report = Report((one(subject="x"), one("fail", subject="y")), {})
    assert report.of("a.b").subject == "y"
    assert report.of("a.b", "x").status == "pass"
    assert worst(report.checks) == "fail"
    tied = Report(
        tuple(replace(one(), subject=s, value=v) for s, v in (("x", 0.5), ("y", 1.5))), {}
    )
    assert tied.of("a.b").subject == "y"
    low = [
        Check("l", "L", v, "", (0.8, None), "pass", "judged", subject=s)
        for s, v in (("x", 1.0), ("y", 0.9))
    ]
    assert Report(tuple(low), {}).of("l").subject == "y"
    with pytest.raises(KeyError, match="no check 'c' for None; it has a\\.b"):
        report.of("c")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.12345, "0.123"),
        (41.26, "41.3"),
        (1_234_567.0, "1\u202f234\u202f567"),
        (1.2e-12, "1.2·10⁻¹²"),
        (3.4e8, "3.4·10⁸"),
        (math.inf, "not finite"),
    ],
)
def test_numbers_as_people_write_them(value: float, text: str) -> None:
    assert number_text(value) == text


@pytest.mark.parametrize(
    ("limit", "unit", "text"),
    [
        (0.1, "mm", "≤ 0.1\u202fmm"),
        (4.5, "deg", "≤ 4.5°"),
        ((0.88, 1.07), "×", "0.88 to 1.07\u202f×"),
        ((0.88, None), "×", "≥ 0.88\u202f×"),
        ((None, 1.07), "", "≤ 1.07"),
        ((None, None), "", ""),
        (None, "mm", ""),
    ],
)
def test_limits_as_people_write_them(limit, unit, text) -> None:
    assert Check("n", "t", 1.0, unit, limit, "pass", "hard").limit_text == text


@pytest.mark.parametrize(
    ("value", "limit", "text"),
    [
        (1.0704, (0.88, 1.07), "1.0704 ×"),
        (0.87996, (0.88, 1.07), "0.87996 ×"),
        (1.00004e-6, 1e-6, "1.00004·10⁻⁶ ×"),
        (1.2004, (0.88, 1.07), "1.2 ×"),
        (1.0696, (0.88, 1.07), "1.07 ×"),
    ],
)
def test_a_value_beyond_a_limit_does_not_look_like_it(value, limit, text) -> None:
    assert measured("n", "t", value, "×", limit=limit).value_text == text


def test_places_are_told_in_millimetres() -> None:
    check = one(where=place([[0.01, -0.0204, 0.0]], 0))
    assert check.where_text == "(10.0, -20.4, 0.0) mm"
    assert one().where_text == ""
    assert unmeasured("n", "t", "mm").value_text == "—"


@pytest.fixture(scope="module")
def report() -> Report:
    scene = ball_scene()
    return tw.check(scene, ball_table(scene, tolerance_mm=2.0), samples=4000)


def test_the_json_file_holds_every_check(report: Report, tmp_path) -> None:
    path = report.save_json(tmp_path / "report.json")
    told = json.loads(path.read_text(encoding="utf-8"))
    assert told["status"] == report.status
    assert [c["name"] for c in told["checks"]] == [c.name for c in report.checks]
    assert told["facts"]["seed"] == 0
    assert {"name", "value", "unit", "limit", "status", "where_m"} <= set(told["checks"][0])


def test_values_that_are_not_finite_are_null(tmp_path) -> None:
    path = Report((one("fail", where=(math.nan, 0.0)),), {}).save_json(tmp_path / "r.json")
    assert json.loads(path.read_text())["checks"][0]["where_m"] == [None, 0.0]


def test_a_folder_is_no_file(report: Report, tmp_path) -> None:
    with pytest.raises(tw.OutputError, match="is a folder"):
        report.save_json(tmp_path)
    with pytest.raises(tw.OutputError, match="is a folder"):
        report.save_html(tmp_path)


def test_the_same_seed_gives_the_same_report(report: Report) -> None:
    scene = ball_scene()
    again = tw.check(scene, ball_table(scene, tolerance_mm=2.0), samples=4000)
    other = tw.check(scene, ball_table(scene, tolerance_mm=2.0), samples=4000, seed=1)
    assert again.checks == report.checks
    assert other.checks != report.checks


def test_a_sound_table_passes_and_a_shifted_warp_fails(report: Report) -> None:
    assert report.with_status("fail", "unknown") == tuple(
        c for c in report.checks if c.status == "unknown" and c.group == "judged"
    )
    bad = tw.check(ball_scene(), shifted(ball_warp(), 0.3), samples=2000)
    assert bad.status == "fail"
    assert headline(bad).startswith("This warp breaks a promise")
    assert any(s.startswith("Fails: contact error, mean of ball is 0.3") for s in sentences(bad))


@pytest.mark.parametrize("width", [60, 110])
def test_the_terminal_shows_every_check(report: Report, width: int) -> None:
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(report)
    text = " ".join(console.export_text().split())
    for heading in ("Hard", "Judged", "Told", headline(report)[:40]):
        assert heading in text
    assert "Folded volume" in text


def test_print_writes_to_the_terminal(report: Report, capsys: pytest.CaptureFixture[str]) -> None:
    report.print()
    assert "Contact error, mean" in capsys.readouterr().out


def test_progress_names_the_families() -> None:
    steps: list[tuple[str, float]] = []
    scene = ball_scene()
    tw.check(
        scene,
        ball_table(scene, ball_bricks()),
        samples=2000,
        progress=lambda s, d: steps.append((s, d)),
    )
    assert steps[0] == ("checking contact", 0.0)
    assert [d for _, d in steps] == sorted(d for _, d in steps)


def test_a_line_without_a_place_says_why() -> None:
    mean = measured("a.mean", "A mean", 1.0, whole="a mean over the whole surface")
    assert mean.nowhere_text == "No one place: it is a mean over the whole surface."
    assert measured("a.most", "A greatest", 0.0, where=(0.0, 0.0)).nowhere_text == (
        "No place: it is 0 wherever it was looked for."
    )
    assert unmeasured("a.most", "A greatest").nowhere_text == "No place: it was not measured."
    assert measured("a.most", "A greatest", 1.0, where=(0.0, 0.0)).nowhere_text == ""
