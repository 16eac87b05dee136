"""A certificate for this machine's network address, made once and kept.

WebXR needs a secure context, which on a network address means HTTPS. The certificate is signed by
itself, so a browser asks once whether to trust it; the printed fingerprint tells that it is this
one. It is kept so that a headset need not be asked again.
"""

from __future__ import annotations

import hashlib
import ipaddress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from touchwarp.outputs import claim_folder, replacing

LIFETIME = timedelta(days=365)
RENEWED_BEFORE_END = timedelta(days=14)


@dataclass(frozen=True)
class HttpsIdentity:
    """Files for the server, and what a person can compare.

    Attributes:
        certificate, key: PEM files; the key can be read by its owner only.
        fingerprint: SHA-256 of the certificate, as browsers show it.
    """

    certificate: Path
    key: Path
    fingerprint: str


def identity_for(address: str, folder: Path) -> HttpsIdentity:
    """The certificate for an IP address or host name, from `folder` or new.

    Raises:
        OutputError: `folder` cannot be written to.
    """
    claim_folder(folder)
    stem = address.replace(":", "_")
    certificate, key = folder / f"{stem}.crt", folder / f"{stem}.key"
    if not (key.exists() and _still_good(certificate)):
        _make(address, certificate, key)
    loaded = x509.load_pem_x509_certificate(certificate.read_bytes())
    digest = hashlib.sha256(loaded.public_bytes(serialization.Encoding.DER)).hexdigest().upper()
    pairs = ":".join(digest[i : i + 2] for i in range(0, len(digest), 2))
    return HttpsIdentity(certificate, key, pairs)


def _still_good(path: Path) -> bool:
    try:
        loaded = x509.load_pem_x509_certificate(path.read_bytes())
    except (OSError, ValueError):
        return False
    return loaded.not_valid_after_utc - RENEWED_BEFORE_END > datetime.now(UTC)


def _make(address: str, certificate: Path, key: Path) -> None:
    private = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"touchwarp on {address}"[:64])])
    try:
        subject: x509.GeneralName = x509.IPAddress(ipaddress.ip_address(address))
    except ValueError:
        subject = x509.DNSName(address)
    now = datetime.now(UTC)
    signed = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(private.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))  # a headset's clock may lag
        .not_valid_after(now + LIFETIME)
        .add_extension(x509.SubjectAlternativeName([subject]), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .sign(private, hashes.SHA256())
    )
    pem = private.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    with replacing(key) as temporary:
        temporary.touch(mode=0o600)
        temporary.chmod(0o600)
        temporary.write_bytes(pem)
    key.chmod(0o600)
    with replacing(certificate) as temporary:
        temporary.write_bytes(signed.public_bytes(serialization.Encoding.PEM))
