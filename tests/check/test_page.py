"""The page stands alone, shows every check, and its pictures show what they say."""

from __future__ import annotations

import base64
import io
import json
import math
import re
from html import unescape
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.image import imread

import touchwarp as tw
from tests.check.stand_ins import (
    Still,
    ball_bricks,
    ball_scene,
    ball_table,
    ball_warp,
    block_scene,
    case_of,
    map_scene,
)
from tests.goals.hand_made_maps import cube_map
from touchwarp.check.case import Case
from touchwarp.check.page import render
from touchwarp.check.page.display_mesh import display_mesh
from touchwarp.check.page.map_view import between_picture, virtual_triangles
from touchwarp.check.page.palette import Picture, css_gradient, unique_ids
from touchwarp.check.page.slices import cut, cut_triangles
from touchwarp.check.page.still import still_picture
from touchwarp.check.page.surface_view import view_data
from touchwarp.check.report import Report
from touchwarp.check.thresholds import JND

MEGABYTES = 8.0


@pytest.fixture(scope="module")
def report() -> Report:
    scene = ball_scene()
    return tw.check(scene, ball_table(scene, ball_bricks(), tolerance_mm=2.0), samples=20_000)


@pytest.fixture(scope="module")
def page(report: Report, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = report.save_html(tmp_path_factory.mktemp("page") / "report.html")
    return path.read_text(encoding="utf-8")


def asked_from_elsewhere(html: str) -> list[str]:
    """Addresses that a browser would fetch."""
    asked = re.findall(r"(?:src|href|srcset)\s*=\s*[\"'](?!data:|#)([^\"']+)", html)
    return asked + re.findall(r"(?:url\(|@import|fetch\()\s*[\"']?(?!#|data:)(\w[^)]*)", html)


def test_the_page_stands_alone(page: str) -> None:
    assert asked_from_elsewhere(page) == []
    assert len(page.encode()) < MEGABYTES * 1e6
    assert page.rstrip().endswith("</html>")


def test_a_page_that_asks_for_a_font_would_be_caught() -> None:
    assert asked_from_elsewhere('<link href="https://fonts.example/a.css">')
    assert asked_from_elsewhere("<style>@import 'x.css'; a { b: url(https://c) }</style>")


def test_every_check_is_on_the_page(report: Report, page: str) -> None:
    text = " ".join(unescape(page).split())
    for check in report.checks:
        assert check.title in text
        assert " ".join(check.value_text.split()) in text
    assert f"verdict {report.status}" in page


def test_pictures_follow_the_theme_and_share_no_ids(page: str) -> None:
    pictures = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len(pictures) >= 14
    assert not any(re.search(r"#0102[0-9a-f]{2}", p) for p in pictures)
    assert all("var(--" in p for p in pictures)
    ids = re.findall(r' id="([^"]+)"', "".join(pictures))
    assert len(ids) == len(set(ids))


def test_names_cannot_break_the_page() -> None:
    from dataclasses import replace

    scene = ball_scene()
    scene = replace(scene, props=[replace(scene.props[0], name="<b>a</b> & </script>")])
    html = render(tw.check(scene, ball_warp(), samples=2000))
    assert "<b>a</b>" not in html
    assert html.count("</script>") == 2


def test_a_report_without_samples_has_no_page() -> None:
    with pytest.raises(ValueError, match="holds no samples to draw"):
        render(Report((), {}))


def test_a_cut_through_a_box_is_its_outline() -> None:
    surface = block_scene().props[0].surface
    segments = cut_triangles(surface.vertices[surface.faces], 2, 0.03)
    assert segments[:, :, 2] == pytest.approx(np.full((len(segments), 2), 0.03))
    assert np.linalg.norm(segments[:, 0] - segments[:, 1], axis=1).sum() == pytest.approx(0.2)
    assert len(cut_triangles(surface.vertices[surface.faces], 2, 0.5)) == 0


def test_cuts_go_through_the_prop_and_end_under_the_table() -> None:
    upright, level = cut(case_of(block_scene(), Still()), case_of(block_scene(), Still()).props[0])
    assert (upright.fixed, level.fixed) == (0.0, 0.05)
    assert upright.ground == 0.0
    assert level.ground is None
    assert -0.02 < upright.low[1] < 0.0
    heights = upright.points[..., 2]
    assert not upright.in_region[heights < 0].any()
    inside = (np.abs(upright.points[..., 0]) < 0.029) & (heights > 0) & (heights < 0.1)
    assert not upright.in_region[inside].any()
    assert upright.place(np.array([[0.01, 0.02]])).tolist() == [[0.01, 0.0, 0.02]]


def unpacked(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), kind)


def test_the_view_shows_felt_and_seen_places() -> None:
    data = view_data(case_of(ball_scene(), ball_warp()))
    json.dumps(data)
    low, high = np.array(data["low"]), np.array(data["high"])
    felt, seen = (
        low + unpacked(data[key], "<u2").reshape(-1, 3) / 65535 * (high - low)
        for key in ("felt", "seen")
    )
    assert len(felt) == data["count"]
    assert np.linalg.norm(felt, axis=1) == pytest.approx(np.full(len(felt), 50.0), abs=0.5)
    assert seen == pytest.approx(1.2 * felt + [10, 0, 0], abs=0.01)
    mismatch = next(f for f in data["fields"] if f["key"] == "mismatch")
    values = mismatch["high"] * unpacked(mismatch["values"], "u1") / 255
    assert values == pytest.approx(np.linalg.norm(seen - felt, axis=1), abs=0.1)


def test_large_faces_are_divided_and_many_are_merged() -> None:
    coarse = view_data(case_of(block_scene(), Still()))
    assert 20_000 < coarse["count"] // 3 <= 40_000
    case = case_of(ball_scene(), ball_warp())
    felt, seen, face = display_mesh(case.props[0], 500)
    assert 200 < len(felt) // 3 <= 500
    assert len(felt) == len(seen) == len(face)


def test_the_still_picture_is_an_image() -> None:
    picture = still_picture(case_of(ball_scene(), ball_warp(), samples=50_000))
    assert base64.b64decode(picture.split(",")[1])[:4] == b"\x89PNG"


def test_a_picture_that_fails_leaves_the_style_alone() -> None:
    import matplotlib

    before = matplotlib.rcParams["font.size"]
    with pytest.raises(ZeroDivisionError), Picture(2, 2) as picture:
        picture.axes.plot([1 / 0])
    assert matplotlib.rcParams["font.size"] == before


def test_ids_and_their_uses_are_renamed_together() -> None:
    svg = '<a id="x"/><use href="#x"/><b clip-path="url(#x)"/>'
    assert unique_ids(svg, "p1") == '<a id="p1-x"/><use href="#p1-x"/><b clip-path="url(#p1-x)"/>'


def test_gradients_run_from_one_end_to_the_other() -> None:
    import matplotlib

    gradient = css_gradient(matplotlib.colormaps["gray"])
    assert gradient.startswith("linear-gradient(to right, #000000")
    assert gradient.endswith("#ffffff)")


@pytest.fixture(scope="module")
def map_case() -> Case:
    return case_of(map_scene(cube_map()), Still(), samples=150_000)


def test_a_map_s_surfaces_carry_one_checkerboard_and_every_quantity(map_case: Case) -> None:
    data = view_data(map_case)
    json.dumps(data)
    assert data["square"] == 7
    assert [f["key"] for f in data["map_fields"]] == [
        *("plain", "area", "greatest", "least", "curvature", "mismatch", "turn", "distance")
    ]
    fields = {f["key"]: f for f in data["map_fields"]}
    for field in fields.values():
        assert len(unpacked(field["values"], "u1")) == data["count"]
    low, high = np.array(data["low"]), np.array(data["high"])
    felt = low + unpacked(data["felt"], "<u2").reshape(-1, 3) / 65535 * (high - low)
    # by rays from the centre area goes as 1 / distance³: most at faces' middles, least at corners
    distance = np.linalg.norm(felt, axis=1)
    area = unpacked(fields["area"]["values"], "u1").astype(float)
    assert np.corrcoef(np.log(distance), area)[0, 1] < -0.95
    # curvature changes along the edges, which the ball has not, and hardly elsewhere
    curvature = unpacked(fields["curvature"]["values"], "u1").astype(float)
    beside = np.sort(np.abs(felt), axis=1)[:, 1] > 39.0
    away = np.sort(np.abs(felt), axis=1)[:, 1] < 25.0
    assert curvature[beside].mean() < 60
    assert curvature[away].mean() == pytest.approx(
        127 * (1 + 20 / fields["curvature"]["high"]), abs=8
    )


@pytest.mark.parametrize(("mode", "marks"), [("slide", (52.0, 31.9)), ("pinch", (52.0, None))])
def test_what_people_notice_is_marked_where_it_is_known(
    mode: str, marks: tuple[float | None, ...]
) -> None:
    data = view_data(case_of(map_scene(cube_map(), mode), Still()))
    fields = {f["key"]: f for f in data["map_fields"]}
    for key, limit in zip(("mismatch", "turn"), marks, strict=True):
        assert fields[key]["mark"] == (None if limit is None else (limit, JND))
    assert fields["distance"]["mark"] == (pytest.approx(0.1), "tolerance")
    assert all(field["note"] for key, field in fields.items() if key != "plain")
    # an end that cuts values off says so, and one that is the greatest of all does not
    assert fields["curvature"]["beyond"] != [False, False]
    assert fields["mismatch"]["beyond"] == [False, False]


def test_the_virtual_object_itself_stands_behind_its_image(map_case: Case) -> None:
    own = virtual_triangles(map_case)
    assert len(own) == 3 * len(cube_map().virtual_surface.faces)
    assert np.linalg.norm(own, axis=1) == pytest.approx(np.full(len(own), 0.05))
    assert len(virtual_triangles(case_of(ball_scene(), ball_warp()))) == 0


def test_the_shapes_between_are_a_row_of_five(map_case: Case) -> None:
    picture = imread(io.BytesIO(base64.b64decode(between_picture(map_case).split(",")[1])))
    height, width, _ = picture.shape
    assert width == 5 * height
    filled = [(picture[:, k * height : (k + 1) * height, 3] > 0).mean() for k in range(5)]
    # a cube of 80 mm shows more of itself than a ball of 100 mm; between them it shrinks
    assert all(a > b for a, b in pairwise(filled))
    # a ball's outline is a circle
    assert filled[-1] / filled[0] == pytest.approx(ball_over_cube(), rel=0.03)


def ball_over_cube() -> float:
    """Areas of the outlines as the picture sees them: a ball's of 50 mm, a cube's of 80 mm."""
    turn, rise = math.radians(-60.0), math.radians(24.0)
    eye = [math.cos(turn) * math.cos(rise), math.sin(turn) * math.cos(rise), math.sin(rise)]
    return math.pi * 50**2 / (80**2 * sum(abs(c) for c in eye))


def test_a_page_with_a_map_shows_it() -> None:
    html = render(tw.check(map_scene(cube_map(edge=6e-3)), Still(), samples=5000))
    assert "The map from prop to virtual object" in html
    assert html.count('name="map-field"') == 8
    assert asked_from_elsewhere(html) == []
    assert len(html.encode()) < MEGABYTES * 1e6
    assert html.count("</script>") == 2


def test_edges_do_not_fray_where_faces_are_merged(map_case: Case) -> None:
    felt, _, _ = display_mesh(map_case.props[0], 4000)
    corners = felt.reshape(-1, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(normals, axis=1)
    level = np.abs(normals).max(axis=1) > 1.999 * area
    assert area[~level].sum() < 0.002 * area.sum()
