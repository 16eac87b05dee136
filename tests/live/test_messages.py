"""Server and page speak of the same messages."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from touchwarp.live.messages import FROM_PAGE, ChangeScene, Placement
from touchwarp.live.typescript import TARGET, type_text, typescript

CHECKOUT = Path(__file__).resolve().parents[2]


def test_the_page_s_types_are_those_of_the_server() -> None:
    assert (CHECKOUT / TARGET).read_text(encoding="utf-8") == typescript(), (
        "run 'python -m touchwarp.live.typescript'"
    )


def test_a_changed_message_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ChangeScene.__annotations__, "mismatch_weight", "str")
    assert (CHECKOUT / TARGET).read_text(encoding="utf-8") != typescript()


def test_a_type_without_typescript_is_told() -> None:
    with pytest.raises(TypeError, match="has no TypeScript yet"):
        type_text(complex)


@pytest.mark.parametrize(
    "text",
    [
        '{"kind": "nonsense"}',
        '{"kind": "change_scene", "mismatch_weight": -1}',
        '{"kind": "change_scene", "mismatch_weight": NaN}',
        '{"kind": "change_scene", "colour": "red"}',
        '{"kind": "change_scene", "goals": {"ball": {"scale": [1, 1]}}}',
        '{"kind": "begin_recording", "recording": "../../etc", "participant": "P1"}',
        "[]",
        "",
        '{"kind": "save_scene"',
    ],
)
def test_what_does_not_fit_is_refused(text: str) -> None:
    with pytest.raises(ValidationError):
        FROM_PAGE.validate_json(text)


def test_what_fits_is_taken() -> None:
    text = (
        '{"kind": "change_scene", "goals": {"a": {"scale": [1, 1, 2], '
        '"rotation_deg": [0, 0, 9], "translation": [0, 0, 0.1]}}}'
    )
    placement = Placement(scale=(1, 1, 2), rotation_deg=(0, 0, 9), translation=(0, 0, 0.1))
    assert FROM_PAGE.validate_json(text) == ChangeScene(goals={"a": placement})
