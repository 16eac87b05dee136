"""Only whom it was shown to comes in from the network, and foreign pages never do."""

from __future__ import annotations

import pytest
from starlette.websockets import WebSocketDisconnect

from tests.live.conftest import LIVE, REMOTE, Served
from touchwarp.live.access import TRIES_A_CODE, Invitation

HEADSET = f"https://{REMOTE}"


def test_this_machine_needs_no_token(served: Served) -> None:
    assert served.client().get("/boot.json").status_code == 200


@pytest.mark.parametrize(
    "path", ["/boot.json", "/tables/x.warp", "/surfaces/x.bin", "/assets/a.js"]
)
def test_the_network_gets_nothing_without_a_token(served: Served, path: str) -> None:
    assert served.client(HEADSET).get(path).status_code == 401


def test_the_network_s_first_page_asks_for_the_code(served: Served) -> None:
    answer = served.client(HEADSET).get("/")
    assert answer.url.path == "/enter"
    assert "Type the code" in answer.text


def test_a_token_lets_one_browser_in_and_no_other(served: Served) -> None:
    first, second = served.client(HEADSET), served.client(HEADSET)
    link = f"/enter?token={served.invitation.token}"
    assert first.get(link).url.path == "/"
    assert first.get("/boot.json").status_code == 200
    assert "not the code shown now" in second.get(link).text
    assert second.get("/boot.json").status_code == 401


def test_the_code_lets_in_as_well(served: Served) -> None:
    headset = served.client(HEADSET)
    assert headset.post("/enter", data={"code": f" {served.invitation.code} "}).url.path == "/"
    assert headset.get("/boot.json").status_code == 200


def test_the_cookie_is_kept_from_scripts_and_other_sites(served: Served) -> None:
    headset = served.client(HEADSET)
    answer = headset.get(f"/enter?token={served.invitation.token}", follow_redirects=False)
    flags = {flag.strip().lower() for flag in answer.headers["set-cookie"].split(";")[1:]}
    assert {"httponly", "secure", "samesite=strict"} <= flags


def test_codes_cannot_be_tried_out() -> None:
    now = 0.0
    invitation = Invitation(clock=lambda: now)
    code, shown = invitation.code, []
    invitation.renewed = lambda new: shown.append(new.code)
    assert invitation.redeem("nonsense") is None
    assert invitation.redeem(code) is None, "within a second of a wrong one not even the right one"
    for _ in range(TRIES_A_CODE - 1):
        now += 2.0
        assert invitation.redeem("nonsense") is None
    now += 2.0
    assert invitation.redeem(code) is None, "too many wrong ones: there is a new code"
    assert len(shown) == 1
    now += 2.0
    assert invitation.redeem(shown[0]) is not None


def test_a_made_up_session_is_none(served: Served) -> None:
    for cookie in ("touchwarp=made-up", "touchwarp=", 'touchwarp="', "a=b"):
        answer = served.client(HEADSET).get("/boot.json", headers={"cookie": cookie})
        assert answer.status_code == 401


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8600", "localhost.evil.example"])
def test_a_name_that_is_led_here_is_refused(served: Served, host: str) -> None:
    answer = served.client().get("/boot.json", headers={"host": host})
    assert answer.status_code == 421


def test_pages_of_other_sites_are_refused(served: Served) -> None:
    answer = served.client().get("/boot.json", headers={"origin": "https://evil.example"})
    assert answer.status_code == 403
    with (
        pytest.raises(WebSocketDisconnect),
        served.client().websocket_connect(LIVE, headers={"origin": "https://evil.example"}),
    ):
        pass


def test_the_network_s_websocket_needs_the_session(served: Served) -> None:
    with (
        pytest.raises(WebSocketDisconnect),
        served.client(HEADSET).websocket_connect(
            f"wss://{REMOTE}/live", headers={"origin": HEADSET}
        ),
    ):
        pass


def test_a_headset_s_own_page_may_talk(served: Served) -> None:
    headset = served.client(HEADSET)
    headset.get(f"/enter?token={served.invitation.token}")
    origin = {"origin": HEADSET}
    with headset, headset.websocket_connect(f"wss://{REMOTE}/live", headers=origin) as socket:
        assert socket.receive_json()["kind"] == "state"


def test_recordings_are_not_shown_to_the_network(served: Served) -> None:
    headset = served.client(HEADSET)
    headset.get(f"/enter?token={served.invitation.token}")
    assert headset.get("/recordings.json").status_code == 403


def test_answers_forbid_foreign_content(served: Served) -> None:
    headers = served.client().get("/").headers
    assert "default-src 'self'" in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"
