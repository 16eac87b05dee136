"""The certificate for a network address: for that address, kept, renewed before its end."""

from __future__ import annotations

import ipaddress
from datetime import timedelta
from pathlib import Path

import pytest
from cryptography import x509

from touchwarp.live import https
from touchwarp.live.https import identity_for


def test_it_names_the_address_and_its_key_is_private(tmp_path: Path) -> None:
    identity = identity_for("192.0.2.7", tmp_path / "https")
    made = x509.load_pem_x509_certificate(identity.certificate.read_bytes())
    names = made.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert names.get_values_for_type(x509.IPAddress) == [ipaddress.ip_address("192.0.2.7")]
    assert identity.key.stat().st_mode & 0o077 == 0
    assert len(identity.fingerprint.split(":")) == 32


def test_it_is_kept_so_that_a_headset_is_asked_once(tmp_path: Path) -> None:
    first = identity_for("192.0.2.7", tmp_path)
    assert identity_for("192.0.2.7", tmp_path).fingerprint == first.fingerprint
    assert identity_for("192.0.2.8", tmp_path).fingerprint != first.fingerprint


def test_it_is_renewed_before_it_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(https, "LIFETIME", timedelta(days=10))
    first = identity_for("192.0.2.7", tmp_path)
    assert identity_for("192.0.2.7", tmp_path).fingerprint != first.fingerprint


def test_a_damaged_one_is_made_anew(tmp_path: Path) -> None:
    first = identity_for("fe80::1", tmp_path)
    first.certificate.write_text("damaged")
    assert identity_for("fe80::1", tmp_path).fingerprint != first.fingerprint


def test_a_host_name_will_do(tmp_path: Path) -> None:
    made = x509.load_pem_x509_certificate(
        identity_for("lab.example", tmp_path).certificate.read_bytes()
    )
    names = made.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert names.get_values_for_type(x509.DNSName) == ["lab.example"]
