"""Issues and checks certificates: elliptic-curve keys (P-256), all PEM. Nothing here touches a
file.

An authority issues two kinds, and neither can pass for the other: a host's is for a server and
contains its addresses, a guest's is for a client and contains the guest's name. This module needs
the package cryptography: call ``errors.need_packages`` before importing it.
"""

import ipaddress
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import NamedTuple

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_pem_private_key,
)
from cryptography.x509.oid import ExtendedKeyUsageOID

from sar_tui.link.zenoh_settings import Credentials

CLOCK_SKEW = timedelta(days=1)
"""Tolerated difference between the clocks of guest and host when a certificate is new."""


class CertificatePair(NamedTuple):
    """Certificate and its private key."""

    certificate: str
    key: str


def create_authority(name: str, at: datetime, days: int) -> CertificatePair:
    """Create a certificate authority, which can only sign certificates."""
    key = ec.generate_private_key(ec.SECP256R1())
    builder = _builder(
        name, x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)]), key, at
    )
    builder = builder.not_valid_after(at + timedelta(days=days))
    builder = builder.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
    signs = x509.KeyUsage(
        digital_signature=False,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=True,
        crl_sign=True,
        encipher_only=False,
        decipher_only=False,
    )
    return _sign(builder.add_extension(signs, critical=True), key, key)


def issue_host(
    by: CertificatePair, names: Sequence[str], at: datetime, days: int
) -> CertificatePair:
    """Issue a host's certificate for its names and addresses."""
    key = ec.generate_private_key(ec.SECP256R1())
    issuer, signer = _load(by)
    builder = _builder("host", issuer.subject, key, at).not_valid_after(at + timedelta(days=days))
    builder = builder.add_extension(
        x509.SubjectAlternativeName(_general_names(names)), critical=False
    )
    return _sign(_leaf(builder, ExtendedKeyUsageOID.SERVER_AUTH), key, signer)


def issue_guest(
    by: CertificatePair, common_name: str, at: datetime, expires: datetime
) -> CertificatePair:
    """Issue a guest's certificate."""
    key = ec.generate_private_key(ec.SECP256R1())
    issuer, signer = _load(by)
    builder = _builder(common_name, issuer.subject, key, at).not_valid_after(expires)
    return _sign(_leaf(builder, ExtendedKeyUsageOID.CLIENT_AUTH), key, signer)


def fingerprint(certificate: str) -> str:
    """Return the SHA-256 of a certificate as hexadecimal digits."""
    return x509.load_pem_x509_certificate(certificate.encode()).fingerprint(hashes.SHA256()).hex()


def is_pair(pair: CertificatePair) -> bool:
    """Return whether the key belongs to the certificate."""
    try:
        _load(pair)
    except (ValueError, TypeError):
        return False
    return True


def is_valid_for_host(
    pair: CertificatePair, by: str, names: Sequence[str], until: datetime
) -> bool:
    """Return whether a host's certificate was issued by ``by``, has all of these names and is valid
    until then.
    """
    try:
        certificate, _ = _load(pair)
        certificate.verify_directly_issued_by(x509.load_pem_x509_certificate(by.encode()))
        certified = certificate.extensions.get_extension_for_class(
            x509.SubjectAlternativeName
        ).value
    except (ValueError, TypeError, InvalidSignature, x509.ExtensionNotFound):
        return False
    return set(_general_names(names)) <= set(certified) and certificate.not_valid_after_utc > until


def expiry(credentials: Credentials, common_name: str) -> datetime:
    """Return when a guest's certificate expires.

    Raises:
        ValueError: it was issued by another authority, for another name or key, or is not a
            certificate.
    """
    try:
        certificate, _ = _load(CertificatePair(credentials.certificate, credentials.key))
        certificate.verify_directly_issued_by(
            x509.load_pem_x509_certificate(credentials.authority.encode())
        )
    except (TypeError, InvalidSignature) as error:
        raise ValueError("issued by another authority") from error
    names = certificate.subject.get_attributes_for_oid(x509.NameOID.COMMON_NAME)
    if [name.value for name in names] != [common_name]:
        raise ValueError("issued for another name")
    return certificate.not_valid_after_utc


def _load(pair: CertificatePair) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
    """Load a pair. Raises ValueError or TypeError if it is damaged or does not belong together."""
    certificate = x509.load_pem_x509_certificate(pair.certificate.encode())
    key = load_pem_private_key(pair.key.encode(), password=None)
    if (
        not isinstance(key, ec.EllipticCurvePrivateKey)
        or key.public_key() != certificate.public_key()
    ):
        raise ValueError("the key belongs to another certificate")
    return certificate, key


def _builder(
    common_name: str, issuer: x509.Name, key: ec.EllipticCurvePrivateKey, at: datetime
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, common_name)]))
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(at - CLOCK_SKEW)
    )


def _leaf(
    builder: x509.CertificateBuilder, usage: x509.ObjectIdentifier
) -> x509.CertificateBuilder:
    builder = builder.add_extension(
        x509.BasicConstraints(ca=False, path_length=None), critical=True
    )
    return builder.add_extension(x509.ExtendedKeyUsage([usage]), critical=True)


def _sign(
    builder: x509.CertificateBuilder,
    key: ec.EllipticCurvePrivateKey,
    signer: ec.EllipticCurvePrivateKey,
) -> CertificatePair:
    certificate = builder.sign(signer, hashes.SHA256())
    secret = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    return CertificatePair(certificate.public_bytes(Encoding.PEM).decode(), secret.decode())


def _general_names(names: Sequence[str]) -> list[x509.GeneralName]:
    found: list[x509.GeneralName] = []
    for name in names:
        try:
            found.append(x509.IPAddress(ipaddress.ip_address(name)))
        except ValueError:
            found.append(x509.DNSName(name))
    return found
