"""A project of one's own, from nothing to a regression that a build server refuses."""

import json
import re
import subprocess
from hashlib import sha256
from importlib import metadata
from pathlib import Path

import pytest

from tests.support.cli import MISSION, mrsfi, mrsfi_json, workspace
from tests.support.tree import ROOT
from tests.tiers import slow

SHORT = ("--generations", "4", "--workers", "1", "--engine", "reference")


@pytest.fixture
def noted(tmp_path_factory, monkeypatch):
    """Notes where pip got mrsfi, in a distribution that is found before the one that is run."""

    def note(origin):
        folder = tmp_path_factory.mktemp("noted")
        info = folder / "mrsfi.dist-info"
        info.mkdir()
        version = metadata.version("mrsfi")
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: mrsfi\nVersion: {version}\n")
        (info / "direct_url.json").write_text(json.dumps(origin), encoding="utf-8")
        monkeypatch.syspath_prepend(folder)

    return note


@pytest.fixture
def clone(noted, tmp_path_factory):
    """Makes a git repository with an origin from which mrsfi is run; returns its commit."""

    def made(origin):
        folder = tmp_path_factory.mktemp("clone")
        git = ("git", "-C", str(folder), "-c", "user.name=t", "-c", "user.email=t@example.org")
        for words in (("init",), ("remote", "add", "origin", origin), ("add", ".")):
            subprocess.run([*git, *words], check=True, capture_output=True)
        subprocess.run(
            [*git, "commit", "--allow-empty", "-m", "x"], check=True, capture_output=True
        )
        noted({"url": folder.as_uri(), "dir_info": {"editable": True}})
        done = subprocess.run(
            [*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True
        )
        return done.stdout.strip()

    return made


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    """A new project, with a campaign in runs/it."""
    folder = tmp_path_factory.mktemp("begun")
    mrsfi("new", "demo", cwd=folder)
    mrsfi("evolve", "demo", *SHORT, "--out", "runs/it", cwd=folder / "demo")
    return folder / "demo"


@slow
def test_a_new_mission_is_sound_fresh_and_violates_nothing(begun):
    validated = mrsfi("validate", "demo", cwd=begun)
    flown = mrsfi_json("simulate", "demo", cwd=begun)

    assert validated.stdout.endswith("8 faults, 0 warnings\n")
    assert validated.stderr == ""
    assert mrsfi("generate", "demo", "--check", cwd=begun).stdout == "fresh: generated/demo\n"
    assert all(goal["true"] == goal["believed"] == goal["missed"] == 0 for goal in flown["goals"])


def test_it_may_begin_with_a_mission_that_there_is(tmp_path):
    place = workspace(tmp_path)

    mrsfi("new", "harbour", "--from", MISSION, cwd=place)

    ours = place / "models" / MISSION
    for path in (place / "harbour" / "models" / "harbour").rglob("*.*"):
        name = path.relative_to(place / "harbour" / "models" / "harbour")
        assert path.read_bytes() == (ours / name).read_bytes()
    assert (
        "1 of 1 kept weaknesses is within its limit"
        in mrsfi("check", "--engine", "reference", cwd=place / "harbour").stdout
    )


@pytest.mark.parametrize(
    "words",
    [
        ("9lives",),
        ("a/b",),
        ("there",),
        ("new", "--from", "nowhere"),
        ("new", "--from", "x", "--import", "there/file"),
    ],
)
def test_what_cannot_be_begun_leaves_nothing(words, tmp_path, approved):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "file").write_text("", encoding="utf-8")

    done = mrsfi("new", *words, cwd=tmp_path, expected=2)

    approved(done.stderr)
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


def _installs(project: Path) -> set[str]:
    """Return what the files for build servers, and the README, have pip install."""
    places = (".gitlab-ci.yml", ".github/workflows/mrsfi.yml", "README.md")
    texts = [(project / place).read_text(encoding="utf-8") for place in places]
    return {installed for text in texts for installed in re.findall(r'pip install "(.*?)"', text)}


def test_build_servers_install_a_wheel_from_the_project_unless_told_otherwise(tmp_path):
    made = mrsfi("new", "demo", cwd=tmp_path)
    mrsfi("new", "other", "--install", "index", cwd=tmp_path)

    wheel = f"vendor/mrsfi-{metadata.version('mrsfi')}-py3-none-any.whl"
    assert _installs(tmp_path / "demo") == {f"{wheel}[fast]"}
    assert f"needed     demo/{wheel} for build servers: `make wheel` builds it\n" in made.stdout
    assert _installs(tmp_path / "other") == {f"mrsfi[fast]=={metadata.version('mrsfi')}"}
    assert not (tmp_path / "other" / "vendor").exists()


@pytest.mark.parametrize("is_changed", [False, True])
def test_the_wheel_that_mrsfi_was_installed_from_is_brought_unless_it_has_changed(
    is_changed, noted, tmp_path
):
    wheel = tmp_path / f"mrsfi-{metadata.version('mrsfi')}-py3-none-any.whl"
    wheel.write_bytes(b"as installed")
    hashes = {"sha256": sha256(wheel.read_bytes()).hexdigest()}
    noted({"url": wheel.as_uri(), "archive_info": {"hashes": hashes}})
    if is_changed:
        wheel.write_bytes(b"built anew")

    made = mrsfi("new", "demo", cwd=tmp_path)

    brought = [path.read_bytes() for path in (tmp_path / "demo" / "vendor").iterdir()]
    assert brought == ([] if is_changed else [b"as installed"])
    assert ("needed" in made.stdout) is is_changed


@pytest.mark.parametrize(
    ("origin", "written"),
    [
        ("https://example.org/team/mrsfi.git", "https://example.org/team/mrsfi.git"),
        ("git@example.org:team/mrsfi.git", "ssh://git@example.org/team/mrsfi.git"),
        ("/srv/git/mrsfi", "file:///srv/git/mrsfi"),
    ],
)
def test_build_servers_install_the_commit_of_the_clone_that_mrsfi_is_run_from(
    origin, written, clone, tmp_path
):
    commit = clone(origin)

    mrsfi("new", "demo", "--install", "git", cwd=tmp_path)

    assert _installs(tmp_path / "demo") == {f"mrsfi[fast] @ git+{written}@{commit}"}


@pytest.mark.parametrize("origin", ["https://me:secret@example.org/mrsfi.git", "$(id)"])
def test_an_origin_that_is_not_for_everybody_is_refused_and_not_printed(origin, clone, tmp_path):
    clone(origin)

    done = mrsfi("new", "demo", "--install", "git", cwd=tmp_path, expected=2)

    assert "found no repository of this mrsfi" in done.stderr
    assert origin not in done.stderr
    assert not (tmp_path / "demo").exists()


def test_what_a_model_of_the_prototype_lacks_ends_as_by_import_and_leaves_nothing(tmp_path):
    (tmp_path / "published.xmi").write_text("<Setup/>", encoding="utf-8")

    mrsfi("new", "harbour", "--import", "published.xmi", cwd=tmp_path, expected=3)

    assert [path.name for path in tmp_path.iterdir()] == ["published.xmi"]


@slow
def test_files_for_build_servers_run_what_the_makefile_has(begun):
    targets = {line.partition(":")[0] for line in (begun / "Makefile").read_text().splitlines()}
    for path in (begun / ".github" / "workflows" / "mrsfi.yml", begun / ".gitlab-ci.yml"):
        text = path.read_text(encoding="utf-8")
        wanted = {word for word in ("validate", "regressions") if f"make {word}" in text}
        assert wanted == {"validate", "regressions"} <= targets
        assert "regressions.xml" in text
    assert (begun / "metamodels" / "faults.evl").read_bytes() == (
        ROOT / "metamodels" / "faults.evl"
    ).read_bytes()
