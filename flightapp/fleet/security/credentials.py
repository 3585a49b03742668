"""The three files with which one machine joins a fleet: the authority's certificate, its own, and its private key."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from flightapp.core.errors import InputError

AUTHORITY = "ca.pem"
CERTIFICATE = "certificate.pem"
KEY = "private.key"


@dataclass(frozen=True, slots=True)
class Credentials:
    """What is in the folder of one machine; times are Unix time."""

    folder: Path
    name: str
    """The certificate's common name: a vehicle of the mission, or an operator."""
    hosts: tuple[str, ...]
    begins_s: float
    ends_s: float

    @property
    def authority(self) -> Path:
        return self.folder / AUTHORITY

    @property
    def certificate(self) -> Path:
        return self.folder / CERTIFICATE

    @property
    def key(self) -> Path:
        return self.folder / KEY


def load_credentials(folder: Path) -> Credentials:
    """InputError with one sentence where a file is missing or unreadable, or where the three do not belong together."""
    authority = read_certificate(folder / AUTHORITY)
    certificate = read_certificate(folder / CERTIFICATE)
    key = read_key(folder / KEY)
    if certificate.public_key() != key.public_key():
        raise InputError(f"{folder / KEY}: is not the key of {CERTIFICATE} beside it; copy the whole folder of one machine")
    try:
        certificate.verify_directly_issued_by(authority)
    except (ValueError, TypeError, InvalidSignature):
        sentence = f"{folder / CERTIFICATE}: was not signed by {AUTHORITY} beside it; copy the whole folder of one machine"
        raise InputError(sentence) from None
    names = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    if len(names) != 1:
        raise InputError(f"{folder / CERTIFICATE}: has {len(names)} common names, one is wanted; make it with 'flightapp keys'")
    return Credentials(
        folder.resolve(),
        str(names[0].value),
        _hosts(certificate),
        certificate.not_valid_before_utc.timestamp(),
        certificate.not_valid_after_utc.timestamp(),
    )


def read_certificate(file: Path) -> x509.Certificate:
    """InputError where there is none."""
    try:
        return x509.load_pem_x509_certificate(_read(file))
    except ValueError:
        raise InputError(f"{file}: is not a certificate in PEM form; make certificates with 'flightapp keys'") from None


def read_key(file: Path) -> ec.EllipticCurvePrivateKey:
    """InputError where there is none of the kind that `flightapp keys` makes."""
    try:
        key = serialization.load_pem_private_key(_read(file), password=None)
    except (ValueError, TypeError):
        raise InputError(f"{file}: is not a private key in PEM form without password; make keys with 'flightapp keys'") from None
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise InputError(f"{file}: is a key of another kind; make keys with 'flightapp keys' (ECDSA P-256)")
    return key


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{file}: no such file; name the folder that 'flightapp keys' made for this machine") from None
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror}") from None


def _hosts(certificate: x509.Certificate) -> tuple[str, ...]:
    try:
        alternatives = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return ()
    return tuple(str(general.value) for general in alternatives)
