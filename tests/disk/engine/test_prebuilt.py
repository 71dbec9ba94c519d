"""The library that a wheel brings is taken only if it is of these sources, whole and in order."""

import json

import pytest

from mrsfi_runtime.engine.compiled import machine_code
from mrsfi_runtime.engine.compiled.machine_code import Library, key_of, sealed, sources_key

NAMES = ["fly", "check"]


def found_in(folder, monkeypatch, names, seal):
    (folder / "kernel.so").write_bytes(b"library")
    (folder / "kernel.json").write_text(json.dumps({"seal": seal, "names": names}))
    monkeypatch.setattr(machine_code, "FOLDER", folder)
    monkeypatch.setattr(machine_code, "_FEATURES", frozenset())
    return machine_code.prebuilt_kernel.__wrapped__()


@pytest.mark.skipif(machine_code.platform.machine() != "x86_64", reason="it is of x86-64")
def test_what_was_sealed_is_taken(tmp_path, monkeypatch):
    seal = sealed(key_of(sources_key(), *NAMES), b"library").decode()

    found = found_in(tmp_path, monkeypatch, NAMES, seal)

    assert found == Library(tmp_path / "kernel.so", tuple(NAMES))


@pytest.mark.parametrize(
    ("sources", "names", "library"),
    [
        ("others", NAMES, b"library"),
        (sources_key(), NAMES[::-1], b"library"),
        (sources_key(), NAMES, b"exchanged"),
    ],
)
def test_what_was_sealed_as_another_is_not(tmp_path, monkeypatch, sources, names, library):
    seal = sealed(key_of(sources, *names), library).decode()

    assert found_in(tmp_path, monkeypatch, NAMES, seal) is None
