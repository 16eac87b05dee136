"""This machine's addresses, and sockets that listen on them."""

from __future__ import annotations

import ipaddress
import socket

from touchwarp.errors import LiveError

LOCAL = "127.0.0.1"
FIND = ("auto", "0.0.0.0", "::")
"""Hosts for which this machine's network address is found: who asks for every address wants the one
that a headset can open."""


def listen(address: str, port: int) -> socket.socket:
    """A listening socket.

    Raises:
        LiveError: the address is not this machine's, or the port is taken.
    """
    try:
        version = ipaddress.ip_address(address).version
    except ValueError:
        raise LiveError(
            f"'{address}' is no IP address; give one of this machine's, or --host alone."
        ) from None
    family = socket.AF_INET6 if version == 6 else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((address, port))
        listening.listen()
    except OSError as error:
        listening.close()
        raise LiveError(
            f"{address} port {port} cannot be used ({error.strerror}); choose another by --port, "
            "or end the program that has it."
        ) from error
    return listening


def chosen_address(host: str) -> str:
    """The address for a host that was asked for; see `FIND`."""
    return network_address() if host in FIND else host


def network_address() -> str:
    """This machine's address on its network, as other machines see it.

    Raises:
        LiveError: it has none.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # A route is looked up; no packet is sent. The address is one reserved for documents.
            probe.connect(("192.0.2.1", 9))
            address = str(probe.getsockname()[0])
        except OSError as error:
            raise LiveError(
                "This machine has no network address; join a network, give an address after "
                "--host, or use a cable and 'adb reverse' without --host."
            ) from error
    return address


def bracketed(address: str) -> str:
    """An address as it stands in a link."""
    return f"[{address}]" if ":" in address else address
