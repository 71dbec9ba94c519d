"""What a team decided on weaknesses is kept beside the models, printed, and checked."""

import shutil
from datetime import date

import pytest

from tests.support.cli import mrsfi
from tests.support.rendezvous import NAME

ACCEPT = ("accept", "--because", "a tether holds it", "--by", "A. Rivera")
FOLDER = f"models/{NAME}/decisions"


@pytest.fixture
def place(found, tmp_path):
    """Folder of a small mission and its campaign runs/it, without decisions."""
    return shutil.copytree(found, tmp_path, dirs_exist_ok=True)


def decide(place, number, *words, expected=0):
    return mrsfi("decide", "runs/it", str(number), *words, cwd=place, expected=expected)


def undated(text):
    return text.replace(str(date.today()), "TODAY")


def test_a_decision_is_a_file_that_names_goal_measure_and_faults(place, approved):
    done = decide(place, 2, *ACCEPT, "--until", "2999-03-01")

    approved(undated(done.stderr))
    path = place / FOLDER / "g1-missed-stop_a.toml"
    approved(undated(path.read_text(encoding="utf-8")))


def test_deciding_again_replaces_the_file_and_prints_what_it_replaced(place, approved):
    decide(place, 2, *ACCEPT)

    done = decide(place, 2, "duplicate", "--of", "1", "--because", "same", "--by", "Li")

    approved(undated(done.stderr))
    (path,) = (place / FOLDER).iterdir()
    approved(undated(path.read_text(encoding="utf-8")))
