"""How long a page takes to open in Chromium, from disk to its first picture: median of some times.

python benchmarks/page.py runs/NAME/report.html [N]
"""

import shutil
import sys
from pathlib import Path
from statistics import median
from time import perf_counter

from playwright.sync_api import sync_playwright


def main() -> None:
    """Open a page so many times, each in a new context; print size and seconds."""
    path, n_times = Path(sys.argv[1]).resolve(), int([*sys.argv, "10"][2])
    seconds = []
    with sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        for _ in range(n_times):
            page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
            began = perf_counter()
            page.goto(path.as_uri())
            page.wait_for_selector("html[data-ready=true]")
            seconds.append(perf_counter() - began)
            page.context.close()
        browser.close()
    print(f"{path.stat().st_size / 1e6:.2f} MB, open in {median(seconds):.2f} s")


if __name__ == "__main__":
    main()
