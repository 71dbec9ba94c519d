"""The page of a campaign in a real browser: Chromium, opened from disk."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import pytest

from benchmarks.fleets import write_fleet
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.recording import Recording
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.glossary import TERMS
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.mission import RESULTS
from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import MISSION, ROOT, edit, mrsfi, workspace
from tests.support.missing import skip
from tests.support.rendezvous import NAME as RENDEZVOUS
from tests.support.rendezvous import write_rendezvous

try:
    from axe_playwright_python.sync_playwright import Axe
    from playwright.sync_api import sync_playwright
except ImportError:
    sync_playwright = None

TICKS = (0, 1, 137, 500, 999)
SERIES = ("x", "y", "speed", "energy")


@dataclass
class Page:
    """A page that a browser shows, and what it said and asked for meanwhile."""

    shown: Any
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def numbers(self) -> list[list[str]]:
        """Return the cells of the table of robots."""
        rows = self.shown.locator("#numbers tbody tr").all()
        return [row.locator("td").all_inner_texts() for row in rows]

    def seek(self, tick: int) -> None:
        """Move the slider, as a person's drag does."""
        self.shown.locator("#tick").fill(str(tick))

    def now(self) -> int:
        """Return the tick that is shown."""
        return int(self.shown.locator("#now").inner_text().split()[1])


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Headless Chromium, as Debian packages it."""
    path = shutil.which("chromium")
    if sync_playwright is None or path is None:
        skip("Chromium or playwright is missing; install both")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextmanager
def opened(chromium: Any, path: Path, fragment: str = "", **options: Any) -> Iterator[Page]:
    """Open a page from disk; afterwards it said no word, and asked for nothing but itself."""
    options = {"viewport": {"width": 1200, "height": 900}} | options
    context = chromium.new_context(**options)
    page = Page(context.new_page())
    page.shown.on("console", lambda message: page.said.append(message.text))
    page.shown.on("pageerror", lambda error: page.said.append(str(error)))
    page.shown.on("dialog", lambda dialog: page.said.append(dialog.message))
    page.shown.on("request", lambda request: page.asked.append(request.url))
    page.shown.goto(path.as_uri() + fragment)
    page.shown.wait_for_selector("html[data-ready=true]")
    yield page
    assert page.said == []
    assert page.asked == [path.as_uri()]
    context.close()


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a fresh campaign of the paper's mission, explained."""
    place = workspace(tmp_path_factory.mktemp("page"))
    size = ("--population", "8", "--generations", "12", "--workers", "1")
    mrsfi("evolve", MISSION, *size, "--engine", "compiled", "--out", "runs/new", cwd=place)
    return place / "runs" / "new"


@pytest.fixture(scope="module", params=["paper", "warehouse", "fleet"])
def any_campaign(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a campaign of the paper's mission, of one of 11 goals, of one of 100 robots."""
    if request.param == "paper":
        found: Path = request.getfixturevalue("campaign")
        return found
    place = tmp_path_factory.mktemp(request.param)
    if request.param == "warehouse":
        line = [sys.executable, ROOT / "examples" / "warehouse" / "warehouse.py", place]
        subprocess.run(line, cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True)
        mrsfi("report", "runs/warehouse-script-1", cwd=place)
        return place / "runs" / "warehouse-script-1"
    write_fleet(place / "models" / "fleet", 100, 120, 30)
    (place / "fleet.toml").write_text("[search]\nalgorithm = 'cover'\n", encoding="utf-8")
    mrsfi("generate", "fleet", cwd=place)
    size = ("--case", "fleet.toml", "--evaluations", "60", "--workers", "1", "--out", "runs/new")
    mrsfi("evolve", "fleet", *size, cwd=place)
    return place / "runs" / "new"


@pytest.fixture(scope="module")
def first(campaign: Path) -> tuple[dict[str, Any], Recording]:
    """A weakness of the first goal that is broken, as the report has it, and its flight."""
    found = json.loads((campaign / "summary.json").read_text(encoding="utf-8"))["weaknesses"]
    told = next(each for each in found["found"] if each["sentences"])
    faults = tuple(
        TimedFault(each["fault"], each["start"], each["finish"], tuple(each["values"]))
        for each in told["witness"]
    )
    return told, ReferenceEngine(load_code(campaign / "generated"), 1).record(faults)


def test_positions_at_some_ticks_are_those_of_the_engine(chromium, campaign, first):
    told, recording = first
    with opened(chromium, campaign / "report.html") as page:
        page.shown.evaluate("number => { location.hash = `#w${number}`; }", told["number"])
        page.shown.wait_for_selector(f"#panel:has-text('weakness {told['number']}')")
        for tick in TICKS:
            page.seek(tick)
            assert page.now() == tick
            for robot, (_, *cells) in enumerate(page.numbers()):
                for name, true, believed in zip(SERIES, cells[::2], cells[1::2], strict=True):
                    step = 10.0 ** -len(true.partition(".")[2])
                    for side, text in (("world", true), ("belief", believed)):
                        found = recording[side]["robots"][name][tick, robot]
                        assert float(text) == pytest.approx(found, abs=step)


def test_counts_are_those_of_the_flight(chromium, campaign, first):
    told, recording = first
    with opened(chromium, campaign / "report.html") as page:
        article = page.shown.locator("#flown article").first
        assert f"({told['goal']})" in article.locator("h3").inner_text()
        rows = article.locator("table").nth(1).locator("tbody tr").all()
        cells = [row.locator("td").all_inner_texts() for row in rows]

    for goal, row in enumerate(cells):
        counts = dict(zip(RESULTS[:4], row[2:6], strict=True))
        assert counts["believed"] == str(int((recording["is_believed"][:, goal] > 0).sum()))
        assert counts["true"] == str(int((recording["is_true"][:, goal] > 0).sum()))


def test_play_slider_keys_and_clicks_do_what_they_say(chromium, campaign):
    with opened(chromium, campaign / "report.html") as page:
        shown = page.shown
        shown.locator("body").press("Home")
        before = page.numbers()
        shown.locator("#play").click()
        for _ in range(200):
            if page.now() > 40:
                break
            shown.wait_for_timeout(50)
        shown.locator("#play").click()
        assert page.numbers() != before
        stopped = page.now()
        assert shown.locator("#play").inner_text() == "Play"

        shown.locator("#step").click()
        assert page.now() == stopped + 1
        shown.locator("body").press("ArrowLeft")
        assert page.now() == stopped
        shown.locator("body").press("End")
        assert page.now() == 999
        shown.locator("body").press("Home")
        assert page.now() == 0
        shown.locator("body").press("n")
        first = page.now()
        assert shown.locator("#event").inner_text().startswith(f"tick {first}: ")
        shown.locator("body").press("n")
        assert page.now() > first > 0
        shown.locator("body").press("p")
        assert page.now() == first

        fault = shown.locator("button.fault:not([disabled])").first
        fault.click()
        shown.wait_for_selector("button.fault[aria-pressed=true]")

        shown.locator("#filter").fill("7")
        rows = shown.locator("#evaluations tbody tr")
        assert all("7" in row.inner_text() for row in rows.all())
        header = shown.locator("#evaluations th button").first
        header.click()  # it is sorted by this column, upwards
        listed = [int(row.locator("td").first.inner_text()) for row in rows.all()]
        assert listed == sorted(listed, reverse=True)


def test_what_is_shown_has_a_link_and_stands_in_the_history(chromium, campaign):
    with CampaignStore.open(campaign) as store:
        evaluation = store.evaluation(7)
    with opened(chromium, campaign / "report.html") as page:
        shown, panel = page.shown, page.shown.locator("#flight-title")
        first = panel.inner_text()
        cells = shown.locator("#matrix .cell").all()
        cells[0].click()
        cells[-1].click()
        shown.wait_for_function(
            "() => document.querySelector('#flight-title').innerText"
            ".endsWith(` weakness ${location.hash.slice(2)}`)"
        )
        last = panel.inner_text()
        link = shown.evaluate("location.hash")
        shown.locator("#filter").fill("7")
        shown.locator("#evaluations a", has_text=re.compile("^7$")).click()
        shown.wait_for_selector("#evaluation h3:has-text('Evaluation 7')")
        names = shown.locator("#evaluation tbody td:first-child").all_inner_texts()
        windows = shown.locator("#evaluation tbody td.number").all_inner_texts()
        command = shown.locator("#evaluation code").first.inner_text()

        assert names == [timed.fault for timed in evaluation.specification]
        assert windows == [str(tick) for timed in evaluation.specification for tick in timed[1:3]]
        assert command.endswith(" --evaluation 7")
        shown.go_back()
        assert shown.evaluate("location.hash") == link
        shown.go_back()
        shown.wait_for_function(
            "text => document.querySelector('#flight-title').innerText !== text", arg=last
        )
        shown.go_back()
        shown.wait_for_function(
            "text => document.querySelector('#flight-title').innerText === text", arg=first
        )
    for name, place in ((link, "#panel"), ("#e7", "#evaluation")):
        with opened(chromium, campaign / "report.html", fragment=name) as page:
            assert page.shown.locator(place).locator("h2, h3").inner_text() in {
                last,
                "Evaluation 7",
            }


def test_every_weakness_has_its_flight(chromium, campaign):
    found = json.loads((campaign / "summary.json").read_text(encoding="utf-8"))["weaknesses"]
    kept = {each["number"]: each["witness"] for each in found["found"]}
    with opened(chromium, campaign / "report.html") as page:
        for number, witness in kept.items():
            page.shown.evaluate("number => { location.hash = `#w${number}`; }", number)
            page.shown.wait_for_selector(f"#flown h3:has-text('weakness {number}')")
            windows = (
                page.shown.locator("#flown table").first.locator("td.number").all_inner_texts()
            )

            assert page.shown.locator("#flight canvas").is_visible()
            assert windows[:2] == [str(witness[0]["start"]), str(witness[0]["finish"])]


@pytest.mark.parametrize("width", [1280, 390, "print"])
def test_no_head_of_a_column_is_cut(chromium, any_campaign, width):
    size = {"width": 700 if width == "print" else width, "height": 800}
    with opened(chromium, any_campaign / "report.html", viewport=size) as page:
        if width == "print":
            page.shown.emulate_media(media="print")
        cut = page.shown.evaluate(
            """() => {
                const cut = (box) => getComputedStyle(box).display !== "inline" && (
                    box.scrollWidth > box.clientWidth + 1 || box.scrollHeight > box.clientHeight + 1
                );
                const heads = [...document.querySelectorAll("th, th *, .row > :first-child")];
                const visible = heads.filter((head) => head.offsetWidth);
                return visible.filter(cut).map((head) => head.innerText);
            }"""
        )
        over = page.shown.evaluate("document.documentElement.scrollWidth")

    assert cut == []
    assert over <= size["width"]


@pytest.mark.parametrize(
    "options",
    [
        {"color_scheme": "light"},
        {"color_scheme": "dark"},
        {"screen": {"width": 400, "height": 800}},
    ],
    ids=["light", "dark", "narrow"],
)
def test_it_is_drawn_in_every_setting(chromium, campaign, tmp_path, options):
    with opened(chromium, campaign / "report.html", **options) as page:
        page.shown.screenshot(path=tmp_path / "page.png", full_page=True)
        inked = page.shown.evaluate(
            "() => { const c = document.querySelector('canvas');"
            " return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(Boolean); }"
        )

    assert inked
    assert (tmp_path / "page.png").stat().st_size > 20_000


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_the_first_screen_says_what_breaks_which_goal(
    chromium, any_campaign, tmp_path, width, height
):
    found = json.loads((any_campaign / "summary.json").read_text(encoding="utf-8"))
    broken = {
        each["goal"] for each in found["weaknesses"]["found"] if each["measure"] != "believed"
    }
    size = {"width": width, "height": height}
    with opened(chromium, any_campaign / "report.html", viewport=size) as page:
        rows = page.shown.locator("#goals tbody tr").all()
        bottoms = [row.bounding_box()["y"] + row.bounding_box()["height"] for row in rows]
        grave = {row.get_attribute("data-goal") for row in rows if row.locator(".verdict").count()
                 and "grave" in (row.get_attribute("class") or "")}  # fmt: skip
        n_seen = sum(bottom <= height for bottom in bottoms)
        wide = page.shown.evaluate("document.documentElement.scrollWidth")
        over = page.shown.evaluate(
            """() => {
                const right = (element) => element.getBoundingClientRect().right;
                const goals = document.querySelector("#goals");
                const cells = [...goals.querySelectorAll("tbody td")].map(right);
                return Math.max(...cells) - right(goals.parentElement);
            }"""
        )
        page.shown.screenshot(path=_shot(tmp_path, any_campaign, width))

    assert grave == broken
    assert n_seen >= min(len(rows), len(broken) + 1)
    assert wide <= width
    assert over < 1.0  # pixels by which a cell lies over what is beside the table
    assert (any_campaign / "report.html").stat().st_size < 3_000_000


@pytest.fixture(scope="module")
def decided(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a campaign of a mission with requirements, one weakness of which is accepted."""
    place = workspace(tmp_path_factory.mktemp("decided"), "undersea")
    mrsfi("evolve", "undersea", "--workers", "1", "--out", "runs/new", cwd=place)
    content = (place / "runs" / "new" / "summary.json").read_text(encoding="utf-8")
    found = [each for each in json.loads(content)["weaknesses"]["found"] if each["requirements"]]
    undetected = (each for each in found if (each["detection"] or {}).get("n_never"))
    number = next(each["number"] for each in undetected if len(each["faults"]) == 1)
    words = (
        "accept",
        "--because",
        "the boat is near",
        "--by",
        "A. Rivera",
        "--until",
        "2999-03-01",
    )
    mrsfi("decide", "runs/new", str(number), *words, cwd=place)
    mrsfi("report", "runs/new", cwd=place)
    return place / "runs" / "new"


@pytest.mark.parametrize("width", [1280, 390, "print"])
def test_one_screen_says_which_requirement_fails_undetected_and_who_accepted_it(
    chromium, decided, tmp_path, width
):
    size = {"width": 700 if width == "print" else width, "height": 844}
    with opened(chromium, decided / "report.html", viewport=size) as page:
        if width == "print":
            page.shown.emulate_media(media="print")
        line = page.shown.locator(".known", has_text="accepted by A. Rivera").first
        row = line.locator("xpath=ancestor::tr")
        row.scroll_into_view_if_needed()
        box = row.bounding_box()
        page.shown.screenshot(path=_shot(tmp_path, decided, width))

        for words in (
            r"requirement R1 \(In 10 s, the vehicle takes at least 20 measurements\.\), severity",
            r"ndetected under nautilus .* \(f\d+\)|does not detect it",
            r"nown since 20\d\d-\d\d-\d\d, accepted by A. Rivera on 20.* until 2999-03-01",
        ):
            assert re.search(words, row.inner_text())
        assert 0 <= box["y"] <= box["y"] + box["height"] < size["height"] + 1


def _shot(place: Path, campaign: Path, width: int | str) -> Path:
    """Return where a picture of a page goes: into docs/images, where that is asked for."""
    wanted = os.environ.get("MRSFI_SCREENSHOTS")
    mission = json.loads((campaign / "summary.json").read_text(encoding="utf-8"))["mission"]
    return (Path(wanted) if wanted else place) / f"page_{mission}_{width}.png"


def test_a_click_on_a_cell_shows_its_weakness_and_what_to_do_next(chromium, campaign):
    with opened(chromium, campaign / "report.html") as page:
        cell = page.shown.locator("#matrix .cell").last
        cell.click()

        assert cell.get_attribute("aria-pressed") == "true"
        said = page.shown.locator("#panel").inner_text()
        assert cell.get_attribute("title") in said
        number = said.split("weakness ")[1].split()[0]
        commands = page.shown.locator("#next code").all_inner_texts()
        assert commands[0].endswith(f" {number}")
        assert commands[0].startswith("mrsfi show ")
        assert any(command.startswith("mrsfi keep ") for command in commands)


def test_on_paper_stand_goals_matrix_and_flight_with_its_cursor(chromium, campaign, tmp_path):
    with opened(chromium, campaign / "report.html", viewport={"width": 700, "height": 990}) as page:
        page.shown.emulate_media(media="print")

        assert all(row.is_visible() for row in page.shown.locator("#goals tbody tr button").all())
        assert page.shown.locator("#matrix .cell").first.is_visible()
        for name in ("canvas", ".cursor", ".row > :first-child", "#next code"):
            assert page.shown.locator(name).first.is_visible()
        assert not page.shown.locator("#play").is_visible()
        page.shown.screenshot(path=_shot(tmp_path, campaign, "print"))


def test_a_term_shows_its_meaning_when_it_has_the_focus(chromium, campaign):
    known = {each.name: each.meaning.replace("`", "") for each in TERMS}
    with opened(chromium, campaign / "report.html") as page:
        terms = page.shown.locator("abbr")
        titles = {each.inner_text(): each.get_attribute("title") for each in terms.all()}
        heads = page.shown.locator("#evaluations th button").all()
        heads = [each.get_attribute("title") for each in heads]
        terms.first.focus()
        shown = terms.first.evaluate("each => getComputedStyle(each, '::after').content")

    assert {*titles.values()} <= {*known.values()}
    used = {"fault", "goal", "tick", "weakness", "variant", "undetected", "detected", "fails"}
    used |= {"mission seed", "false alarm", "margin", "true", "believed", "evaluation", "fitness"}
    assert {known[name] for name in used} <= {*titles.values()}
    assert heads[2] == known["fitness"]
    assert titles["undetected"] == titles["masked"] == known["undetected"]
    assert shown in {json.dumps(each) for each in known.values()}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_no_page_has_a_fault_of_accessibility(chromium, any_campaign, scheme, width):
    context = chromium.new_context(
        viewport={"width": width, "height": 800}, bypass_csp=True, color_scheme=scheme
    )
    page = context.new_page()
    page.goto((any_campaign / "report.html").as_uri())
    page.wait_for_selector("html[data-ready=true]")
    page.locator("#matrix .cell").last.click()
    page.locator("#evaluations a").nth(3).click()
    page.wait_for_selector("#evaluation h3")

    found = Axe().run(page).response["violations"]

    assert [(each["id"], each["nodes"][0]["html"]) for each in found] == []
    context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_of_a_history_has_no_fault_of_accessibility(chromium, campaign, scheme):
    page, place = campaign.parent.parent / f"{scheme}.html", campaign.parent.parent
    mrsfi("history", "--engine", "compiled", "--workers", "1", "--html", page.name, cwd=place)

    size = {"width": 390 if scheme == "light" else 1280, "height": 800}
    with opened(chromium, page, viewport=size, bypass_csp=True, color_scheme=scheme) as shown:
        found = Axe().run(shown.shown).response["violations"]
        marks = shown.shown.locator("#table-1 tbody td").all_inner_texts()

    assert [(each["id"], each["nodes"][0]["html"]) for each in found] == []
    assert marks[0] == "new"
    assert {*marks[1:]} == {"●"}


def test_a_campaign_of_hostile_names_is_shown_and_does_nothing(chromium, tmp_path):
    write_rendezvous(tmp_path)
    mission = tmp_path / "models" / RENDEZVOUS / "mission.xmi"
    hostile = "<img src=x onerror=alert(1)></script><script>alert(1)</script>\u2028{{data}}"
    text = escape(hostile, {'"': "&quot;", "\u2028": "&#x2028;"})
    for name in ('ID="a" name="a"', 'ID="g1" name=""'):
        edit(mission, name, f'{name.split()[0]} name="{text}"')
    edit(mission, 'ID="g1" ', f'ID="g1" requirements="Q" severity="9" integrityLevel="{text}" ')
    first = '  <goals ID="g1"'
    edit(mission, first, f'  <requirements ID="Q" text="{text}"/>\n{first}')
    (tmp_path / "c.toml").write_text("[search]\nalgorithm = 'cover'\n", encoding="utf-8")
    mrsfi("generate", RENDEZVOUS, cwd=tmp_path)
    size = ("--case", "c.toml", "--evaluations", "60", "--engine", "reference", "--workers", "1")
    mrsfi("evolve", RENDEZVOUS, *size, "--out", "runs/it", cwd=tmp_path)
    why = ("--because", "<img src=x onerror=alert(2)>", "--by", "</script>=1+1")
    mrsfi("decide", "runs/it", "1", "accept", *why, cwd=tmp_path)
    mrsfi("history", *size[4:], "--html", "change.html", cwd=tmp_path)

    for path in (tmp_path / "runs" / "it" / "report.html", tmp_path / "change.html"):
        with opened(chromium, path) as page:
            scripts = page.shown.locator("script").count()
            for place in page.shown.locator("#matrix .cell, #evaluations tbody a").all()[:20]:
                place.click()
            assert hostile in page.shown.locator("body").text_content()
            assert page.shown.locator("img").count() == 0
            assert page.shown.locator("script").count() == scripts == 2
