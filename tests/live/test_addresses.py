"""Which of this machine's addresses is served on."""

from __future__ import annotations

import pytest

from touchwarp.errors import LiveError
from touchwarp.live import addresses
from touchwarp.live.addresses import listen


def test_a_taken_port_is_told() -> None:
    first = listen("127.0.0.1", 0)
    with first, pytest.raises(LiveError, match=r"cannot be used .*choose another by --port"):
        listen("127.0.0.1", first.getsockname()[1])


def test_an_address_is_needed() -> None:
    with pytest.raises(LiveError, match="'elsewhere' is no IP address"):
        listen("elsewhere", 0)


def test_every_address_means_the_one_to_open(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(addresses, "network_address", lambda: "192.0.2.5")
    assert {addresses.chosen_address(host) for host in addresses.FIND} == {"192.0.2.5"}
    assert addresses.chosen_address("192.0.2.7") == "192.0.2.7"


def test_no_network_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class Unreachable:
        def __enter__(self) -> Unreachable:
            return self

        def __exit__(self, *error: object) -> None: ...

        def connect(self, address: object) -> None:
            raise OSError("Network is unreachable")

    monkeypatch.setattr(addresses.socket, "socket", lambda *kinds: Unreachable())
    with pytest.raises(LiveError, match="no network address"):
        addresses.network_address()
