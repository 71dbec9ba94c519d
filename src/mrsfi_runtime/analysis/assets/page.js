// The page: the first screen, then the specification that is shown, search, evaluations and record.

function flownOf(shown) {
  return make("article", {}, make("h3", {}, bdi(shown.title)),
    table(shown.faults.header, shown.faults.rows), titled(shown.counts), commandOf("Simulate it again", shown.command),
    make("details", {}, make("summary", {}, "The fault specification as XMI"), copying(shown.xmi), make("pre", { dir: "ltr" }, shown.xmi)));
}

function chart(place, { title, x, y, xs, lines, points }) {
  const stroke = colour("ink"), grid = { stroke: colour("grid") };
  const series = lines.map(({ label }, k) => ({ label, stroke: palette[k], width: points ? 0 : 1.6, points: { show: Boolean(points), size: 6, fill: palette[k] } }));
  return new uPlot({ title, width: Math.max(240, Math.min(560, document.body.clientWidth - 40)), height: 260, scales: { x: { time: false } }, legend: { live: false },
    axes: [{ label: x, stroke, grid }, { label: y, stroke, grid, size: 64 }], series: [{ label: x }, ...series] }, [xs, ...lines.map(({ values }) => values)], place);
}

function searchOf(search) {
  const place = make("div", { class: "side" });
  const element = make("section", { id: "search" }, make("h2", {}, "Search"), make("p", {}, bdi(search.said)), place);
  requestAnimationFrame(() => search.charts.forEach((each) => {
    const box = make("div");
    place.append(box);
    chart(box, each);
  }));
  return element;
}

function evaluationsOf(data) {
  const one = make("div", { id: "evaluation", "aria-live": "polite" });
  const open = async (index) => {
    const place = data.rows.findIndex(([each]) => each === index), command = `${data.command} ${index}`;
    const faults = data.faults && place >= 0 ? await opened(data.faults) : null;
    one.replaceChildren(make("article", {}, make("h3", { tabindex: "-1" }, `Evaluation ${index}`),
      faults ? table(["fault", "type", "start", "finish", "target", "values"], faults.of[place].map((k) => faults.rows[k])) : make("p", { class: "note" }, "This page does not include its faults. The command prints them."),
      commandOf("Simulate it again", command), commandOf("As a page", `${command} --html evaluation-${index}.html`)));
    withTerms(one).querySelector("h3").focus();
  };
  const most = 200, body = make("tbody"), state = { column: 0, up: true, text: "" };
  const count = make("output", { class: "note" });
  const fill = () => {
    const found = data.rows.filter((row) => !state.text || row.some((cell) => String(cell).includes(state.text)));
    const sign = state.up ? 1 : -1, by = (a, b) => (a === b ? 0 : a === null ? 1 : b === null ? -1 : a < b ? -sign : sign);
    found.sort((a, b) => by(a[state.column], b[state.column]));
    body.replaceChildren(...found.slice(0, most).map((row) => make("tr", { on: { click: () => { location.hash = `#e${row[0]}`; } } }, row.map((cell, k) => make("td", { class: "number" }, k ? number(cell) : make("a", { href: `#e${cell}` }, cell))))));
    count.textContent = `${found.length} of ${data.rows.length} rows${found.length > most ? `; the first ${most} are shown` : ""}`;
  };
  const head = data.header.map((name, k) => make("th", { class: "number", "aria-sort": "none" }, make("button", { type: "button", title: meaningOf(name), on: { click: () => {
    Object.assign(state, { up: state.column === k ? !state.up : true, column: k });
    head.forEach((each, place) => each.setAttribute("aria-sort", place === k ? (state.up ? "ascending" : "descending") : "none"));
    fill();
  } } }, bdi(name))));
  fill();
  const element = make("section", { id: "evaluations" }, make("h2", {}, "Evaluations"), make("p", { class: "note" }, data.title, " Click a row to see its faults."),
    make("p", { class: "controls" }, make("label", {}, "Rows that contain ", make("input", { type: "search", id: "filter", on: { input: (event) => { state.text = event.target.value; fill(); } } })), count), one,
    make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "evaluations" }, make("table", {}, make("thead", {}, make("tr", {}, head)), body)));
  return { element, open };
}

function recordOf(rows) {
  return make("section", { id: "record" }, make("h2", {}, "Record"), table(["name", "value"], rows));
}

async function main() {
  const data = JSON.parse(document.getElementById("data").textContent);
  explain(data.terms);
  document.title = data.title;
  const view = data.mission ? new FlightView(data.mission, data.fault_free) : null, flown = make("section", { id: "flown" });
  const show = (shown) => flown.replaceChildren(make("h2", {}, "Faults and outcome"), withTerms(flownOf(shown)));
  const screen = data.first ? new Screen(data, view, show) : null, evaluations = data.evaluations ? evaluationsOf(data.evaluations) : null;
  const entry = !screen && data.shown ? await opened(data.shown[0]) : null, only = entry && entry.flight, sections = [];
  if (screen) sections.push(["weaknesses", "Goals", screen.element]);
  if (only) sections.push(["flight", "The flight", view.element]);
  if (screen || only) sections.push(["numbers-of-the-flight", "The flight in numbers", view.details]);
  if (data.shown) sections.push(["flown", "Faults and outcome", flown]);
  if (entry) show(entry);
  (data.tables || []).forEach((each, k) => sections.push([`table-${k + 1}`, each.title, make("section", { id: `table-${k + 1}` }, titled(each))]));
  if (data.search) sections.push(["search", "Search", searchOf(data.search)]);
  if (evaluations) sections.push(["evaluations", "Evaluations", evaluations.element]);
  sections.push(["record", "Record", recordOf(data.record)]);
  const links = sections.map(([id, label]) => make("li", {}, make("a", { href: `#${id}` }, label)));
  document.body.append(
    make("header", {}, screen ? screen.header() : make("h1", {}, bdi(data.title))),
    make("main", {}, sections.map(([, , element]) => (screen && element === screen.element ? element : withTerms(element)))),
    make("footer", { class: "note" }, make("nav", { "aria-label": "sections" }, make("ul", {}, links)),
      "Keys: space plays or pauses; ← and → move by one tick, with shift by ten; n and p go to the next or previous event; f follows robots; Home and End go to the first or last tick. CI: collective intelligence."));
  if (only) await view.show(only);
  // #w6 is weakness 6, #e123 evaluation 123; other links lead to sections.
  const follow = async () => {
    const [, kind, number] = /^#([we])(\d+)$/.exec(location.hash) || [];
    if (screen) await screen.follow(kind === "w" ? Number(number) : null);
    if (evaluations && kind === "e") await evaluations.open(Number(number));
  };
  addEventListener("hashchange", follow);
  await follow();
  document.documentElement.dataset.ready = "true";
}

main();
