"""What it takes to see a flight or a campaign: time and size of pages, bags and reports.

Run ``python -m benchmarks.seen`` from the project's root after ``make install``. Times are seconds
of processors of whole commands, each beside that of a search of the paper's mission; where Chromium
and playwright are installed, the script time of a frame of each page follows.
"""

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from benchmarks.fleets import write_fleet
from benchmarks.measuring import MEBI, Others, Run, run_in

MISSION = "uuv_sampling"
N_ROBOTS, N_TICKS = 50, 5_000
ROUNDS = 3
N_FRAMES = 200
KINDS = ("log", "trace", "html", "mcap")


def main() -> None:
    """Print the tables."""
    others = Others()
    with tempfile.TemporaryDirectory(prefix="mrsfi-seen-") as name:
        place = Path(name)
        for folder in ("models", "generated"):
            shutil.copytree(Path(folder) / MISSION, place / folder / MISSION)
        write_fleet(place / "models" / "fleet", N_ROBOTS, N_TICKS, 1)
        _mrsfi(place, "generate", "fleet")
        out = ("--no-explain", "--out")
        _mrsfi(place, "evolve", MISSION, *out, "runs/first")  # compiles, or loads what is compiled
        searches = [_mrsfi(place, "evolve", MISSION, *out, f"runs/{k}") for k in range(ROUNDS)]
        search = median(each.processor for each in searches)
        print(f"search of {MISSION} from start to end: {search:.2f} s of processors")
        _mrsfi(place, "evolve", MISSION, "--out", "runs/told")
        _tell_report(place, search)
        for mission in (MISSION, "fleet"):
            _tell_flight(place, mission, search)
        print(f"\nother programs kept {others.processors():.2f} processors busy")
        for line in _frames([place / "runs/told/report.html", *sorted(place.glob("*.html"))]):
            print(line)


def _mrsfi(place: Path, *words: str) -> Run:
    program = Path(sys.executable).with_name("mrsfi")
    return run_in(place, [str(program), *words], os.environ)


def _tell_report(place: Path, search: float) -> None:
    took = median(_mrsfi(place, "report", "runs/told").processor for _ in range(ROUNDS))
    size = (place / "runs" / "told" / "report.html").stat().st_size / MEBI
    print(f"report of it, all tables, figures and page: {took:.2f} s, {took / search:.2f} of it")
    print(f"its page: {size:.2f} MiB")


def _tell_flight(place: Path, mission: str, search: float) -> None:
    """Print what each file of a flight costs beyond the flight."""
    words = ("simulate", mission, "--engine", "reference")
    rounds = ROUNDS if mission == MISSION else 1
    bare = median(_mrsfi(place, *words).processor for _ in range(rounds))
    print(f"\n{mission}: command that flies once {bare:.2f} s")
    for kind in KINDS:
        file = f"{mission}.{kind}"
        took = [_mrsfi(place, *words, f"--{kind}", file).processor - bare for _ in range(rounds)]
        size = (place / file).stat().st_size / MEBI
        more = median(took)
        print(f"--{kind:6} {more:6.2f} s more, {more / search:5.2f} of the search, {size:6.2f} MiB")


def _frames(pages: list[Path]) -> Iterator[str]:
    """Yield how long the script of pages takes for a frame."""
    chromium = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415 - optional
    except ImportError:
        chromium = None
    if chromium is None:
        yield "no Chromium with playwright: no frames were measured"
        return
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for path in pages:
            page = browser.new_page()
            page.goto(path.as_uri())
            page.wait_for_selector("html[data-ready=true]", timeout=120_000)
            last = int(page.locator("#tick").get_attribute("max") or 0)
            taken = []
            for k in range(N_FRAMES):
                page.locator("#tick").fill(str(last * (k + 1) // N_FRAMES))
                taken.append(float(page.locator("#flight").get_attribute("data-frame") or "nan"))
            yield f"{path.name}: {median(taken):.1f} ms a frame, {max(taken):.1f} at most"
        browser.close()


if __name__ == "__main__":
    main()
