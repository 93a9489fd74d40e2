"""Certificates: made, and seen through. Elliptic-curve keys (P-256), all PEM; nothing here touches a file.

An authority makes two kinds, and neither can pass for the other: a host's serves and names where it is reached, a
guest's only calls and names its bearer. This module needs the package cryptography:
ask ``errors.need_packages`` first.
"""

import ipaddress
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import NamedTuple

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, load_pem_private_key
from cryptography.x509.oid import ExtendedKeyUsageOID

from sar_tui.link.settings import Credentials

SKEW = timedelta(days=1)
"""So far a guest's clock and the host's may be apart when a certificate is new."""


class Pair(NamedTuple):
    """A certificate and its private key."""

    certificate: str
    key: str


def authority(name: str, at: datetime, days: int) -> Pair:
    """Who vouches for the others: signs certificates, and does nothing else."""
    key = ec.generate_private_key(ec.SECP256R1())
    made = _begun(name, x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)]), key, at)
    made = made.not_valid_after(at + timedelta(days=days))
    made = made.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
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
    return _signed(made.add_extension(signs, critical=True), key, key)


def host(by: Pair, names: Sequence[str], at: datetime, days: int) -> Pair:
    """A host's certificate, for the names and addresses that it is reached under."""
    key = ec.generate_private_key(ec.SECP256R1())
    issuer, signer = _opened(by)
    made = _begun("host", issuer.subject, key, at).not_valid_after(at + timedelta(days=days))
    made = made.add_extension(x509.SubjectAlternativeName(_general(names)), critical=False)
    return _signed(_leaf(made, ExtendedKeyUsageOID.SERVER_AUTH), key, signer)


def guest(by: Pair, common_name: str, at: datetime, expires: datetime) -> Pair:
    """A guest's certificate."""
    key = ec.generate_private_key(ec.SECP256R1())
    issuer, signer = _opened(by)
    made = _begun(common_name, issuer.subject, key, at).not_valid_after(expires)
    return _signed(_leaf(made, ExtendedKeyUsageOID.CLIENT_AUTH), key, signer)


def fingerprint(certificate: str) -> str:
    """SHA-256 of a certificate, as hexadecimal digits."""
    return x509.load_pem_x509_certificate(certificate.encode()).fingerprint(hashes.SHA256()).hex()


def fits(pair: Pair) -> bool:
    """Whether it is a certificate and its own key."""
    try:
        _opened(pair)
    except (ValueError, TypeError):
        return False
    return True


def serves(pair: Pair, by: str, names: Sequence[str], until: datetime) -> bool:
    """Whether a host's certificate is of that authority, fits its key, names all of these, and is good till then."""
    try:
        certificate, _ = _opened(pair)
        certificate.verify_directly_issued_by(x509.load_pem_x509_certificate(by.encode()))
        held = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (ValueError, TypeError, InvalidSignature, x509.ExtensionNotFound):
        return False
    return set(_general(names)) <= set(held) and certificate.not_valid_after_utc > until


def expiry(credentials: Credentials, common_name: str) -> datetime:
    """When a guest's certificate ends.

    Raises:
        ValueError: it was made by another authority, for somebody else, or for another key; or is no certificate.
    """
    try:
        certificate, _ = _opened(Pair(credentials.certificate, credentials.key))
        certificate.verify_directly_issued_by(x509.load_pem_x509_certificate(credentials.authority.encode()))
    except (TypeError, InvalidSignature) as error:
        raise ValueError("not of that authority") from error
    names = certificate.subject.get_attributes_for_oid(x509.NameOID.COMMON_NAME)
    if [name.value for name in names] != [common_name]:
        raise ValueError("made for somebody else")
    return certificate.not_valid_after_utc


def _opened(pair: Pair) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
    """Raises ValueError or TypeError: they are damaged, or do not belong together."""
    certificate = x509.load_pem_x509_certificate(pair.certificate.encode())
    key = load_pem_private_key(pair.key.encode(), password=None)
    if not isinstance(key, ec.EllipticCurvePrivateKey) or key.public_key() != certificate.public_key():
        raise ValueError("the key is another's")
    return certificate, key


def _begun(
    common_name: str, issuer: x509.Name, key: ec.EllipticCurvePrivateKey, at: datetime
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, common_name)]))
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(at - SKEW)
    )


def _leaf(made: x509.CertificateBuilder, usage: x509.ObjectIdentifier) -> x509.CertificateBuilder:
    made = made.add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
    return made.add_extension(x509.ExtendedKeyUsage([usage]), critical=True)


def _signed(made: x509.CertificateBuilder, key: ec.EllipticCurvePrivateKey, signer: ec.EllipticCurvePrivateKey) -> Pair:
    certificate = made.sign(signer, hashes.SHA256())
    secret = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    return Pair(certificate.public_bytes(Encoding.PEM).decode(), secret.decode())


def _general(names: Sequence[str]) -> list[x509.GeneralName]:
    found: list[x509.GeneralName] = []
    for name in names:
        try:
            found.append(x509.IPAddress(ipaddress.ip_address(name)))
        except ValueError:
            found.append(x509.DNSName(name))
    return found
