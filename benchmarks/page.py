"""How large the page of a campaign is, how long it takes to open, and what axe says of it.

Run ``python -m benchmarks.page`` from the project's folder, after ``make .venv/.installed-interop``
and with Chromium. It makes two campaigns and prints the table of ``results/page.md``; or it takes
pages: ``python -m benchmarks.page runs/NAME/report.html ...``. The campaigns are the paper's
(``make evolve``), and 3,000 evaluations of ``cover`` on ``fleet_30`` with each fault of its pool
twice, because no mission of ``models`` has a hundred weaknesses.

Times are medians of N_TIMES, each in a new window: from the file on disk to the drawn page, and
from a click on a cell of the matrix to the drawn flight of its weakness.
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any, NamedTuple

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright

N_TIMES = 10
SIZES = ((1280, 800), (390, 844))
SCHEMES = ("light", "dark")
MRSFI = (sys.executable, "-m", "mrsfi_runtime.cli.main")
TWICE = "fleet_30, each fault twice"


class Measured(NamedTuple):
    """A page: numbers of weaknesses and of those with a flight, bytes, seconds, violations."""

    weaknesses: int
    flights: int
    size: int
    opened: float
    chosen: float
    violations: int

    def row(self, name: str) -> str:
        """Return it as a row of the table."""
        cells = f"{self.weaknesses} | {self.flights} | {self.size / 1e6:.2f} MB"
        times = f"{self.opened:.2f} s | {self.chosen:.2f} s"
        return f"| {name} | {cells} | {times} | {self.violations} |"


def campaigns(folder: Path) -> Iterator[tuple[str, Path]]:
    """Make the campaigns in a folder; yield a name and the page of each."""
    for name in ("uuv_sampling", "fleet_30"):
        shutil.copytree(Path("models") / name, folder / "models" / name)
    pool = folder / "models" / "fleet_30" / "faults.xmi"
    text = pool.read_text(encoding="ascii")
    more = re.sub(r'(<faults ID="\w+)"', r'\1_too"', text)
    faults = "".join(re.findall(r"  <faults ID.*?</faults>\n", more, re.DOTALL))
    pool.write_text(text.replace("</faults:", f"{faults}</faults:"), encoding="ascii")
    (folder / "cover.toml").write_text("[search]\nalgorithm = 'cover'\n", encoding="utf-8")
    cover = ("--case", "cover.toml", "--evaluations", "3000")
    for mission, words, name in (("uuv_sampling", (), "uuv_sampling"), ("fleet_30", cover, TWICE)):
        for line in (
            ("generate", mission),
            ("evolve", mission, *words, "--out", f"runs/{mission}"),
        ):
            subprocess.run((*MRSFI, *line), cwd=folder, check=True, capture_output=True)
        yield name, folder / "runs" / mission / "report.html"


def measured(browser: Any, path: Path) -> Measured:
    """Open a page N_TIMES, choose another weakness each time; then ask axe in all settings."""
    opened, chosen = [], []
    for k in range(N_TIMES):
        page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
        began = perf_counter()
        page.goto(path.as_uri())
        page.wait_for_selector("html[data-ready=true]")
        opened.append(perf_counter() - began)
        cells = page.locator("#matrix .cell")
        cell = cells.nth(1 + k * (cells.count() - 2) // N_TIMES)
        before = page.locator("#flown h3").inner_text()
        began = perf_counter()
        cell.click()
        page.wait_for_function(
            "before => document.querySelector('#flown h3').innerText !== before", arg=before
        )
        chosen.append(perf_counter() - began)
        page.context.close()
    n_violations = sum(
        len(_axe(browser, path, size, scheme)) for size in SIZES for scheme in SCHEMES
    )
    data = json.loads(re.findall('id="data">(.*?)</script>', path.read_text(encoding="utf-8"))[0])
    numbers = len(data["first"]["ways"]), len(data["shown"]), path.stat().st_size
    return Measured(*numbers, median(opened), median(chosen), n_violations)


def _axe(browser: Any, path: Path, size: tuple[int, int], scheme: str) -> list[Any]:
    view = dict(zip(("width", "height"), size, strict=True))
    context = browser.new_context(viewport=view, color_scheme=scheme, bypass_csp=True)
    page = context.new_page()
    page.goto(path.as_uri())
    page.wait_for_selector("html[data-ready=true]")
    found: list[Any] = Axe().run(page).response["violations"]
    context.close()
    return found


def main() -> None:
    """Print a row for each page."""
    print("| Campaign | Weaknesses | With a flight | Size | Opens in | Chosen in | axe |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        given = [(path, Path(path).resolve()) for path in sys.argv[1:]]
        for name, path in given or campaigns(Path(folder).resolve()):
            print(measured(browser, path).row(name), flush=True)
        browser.close()


if __name__ == "__main__":
    main()
