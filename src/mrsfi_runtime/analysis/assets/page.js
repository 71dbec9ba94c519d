// The page: the first screen, then simulated specifications, search, evaluations and record.

function flownOf(data) {
  return make("section", { id: "flown" }, make("h2", {}, data.heading),
    data.shown.map((shown) => make("article", {},
      make("h3", {}, bdi(shown.title)),
      shown.sentence ? make("p", {}, bdi(shown.sentence, new Set())) : null,
      table(shown.faults.header, shown.faults.rows),
      titled(shown.counts),
      make("div", { class: "command" }, make("span", {}, "Simulate it again"), make("code", {}, bdi(shown.command)), copying(shown.command)),
      make("details", {}, make("summary", {}, "The fault specification as XMI"), copying(shown.xmi), make("pre", { dir: "ltr" }, shown.xmi)))));
}

function chart(place, { title, x, y, lines, points }) {
  const ink = colour("ink"), grid = colour("grid");
  const series = lines.map(([label, shade, , dash]) => ({ label, stroke: shade, width: points ? 0 : 1.6, dash, points: { show: Boolean(points), size: 6, fill: shade } }));
  const axis = (label) => ({ label, stroke: ink, grid: { stroke: grid } });
  return new uPlot({ title, width: Math.max(240, Math.min(560, document.body.clientWidth - 40)), height: 260, scales: { x: { time: false } }, legend: { live: false },
    axes: [axis(x), { ...axis(y), size: 64 }], series: [{ label: x }, ...series] }, [lines.xs, ...lines.map(([, , values]) => values)], place);
}

function searchOf(search) {
  const place = make("div", { class: "side" });
  const element = make("section", { id: "search" }, make("h2", {}, "Search"), make("p", {}, bdi(search.said)), place);
  requestAnimationFrame(() => search.charts.forEach((each) => {
    const lines = each.lines.map((line, k) => [line.label, palette[k], line.values]);
    lines.xs = each.xs;
    const box = make("div");
    place.append(box);
    chart(box, { ...each, lines });
  }));
  return element;
}

function evaluationsOf(data) {
  const most = 200, body = make("tbody"), state = { column: 0, up: true, text: "" };
  const count = make("output", { class: "note" });
  const fill = () => {
    const found = data.rows.filter((row) => !state.text || row.some((cell) => String(cell).includes(state.text)));
    const sign = state.up ? 1 : -1, by = (a, b) => (a === b ? 0 : a === null ? 1 : b === null ? -1 : a < b ? -sign : sign);
    found.sort((a, b) => by(a[state.column], b[state.column]));
    body.replaceChildren(...found.slice(0, most).map((row) => make("tr", {}, row.map((cell) => make("td", { class: "number" }, number(cell))))));
    count.textContent = `${found.length} of ${data.rows.length} rows${found.length > most ? `; the first ${most} are shown` : ""}`;
  };
  const head = data.header.map((name, k) => make("th", { class: "number", "aria-sort": "none" }, make("button", { type: "button", title: meanings.get(name), on: { click: () => {
    Object.assign(state, { up: state.column === k ? !state.up : true, column: k });
    head.forEach((each, place) => each.setAttribute("aria-sort", place === k ? (state.up ? "ascending" : "descending") : "none"));
    fill();
  } } }, bdi(name))));
  fill();
  return make("section", { id: "evaluations" }, make("h2", {}, "Evaluations"), make("p", { class: "note" }, data.title),
    make("p", { class: "controls" }, make("label", {}, "Rows that contain ", make("input", { type: "search", id: "filter", on: { input: (event) => { state.text = event.target.value; fill(); } } })), count),
    make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "evaluations" }, make("table", {}, make("thead", {}, make("tr", {}, head)), body)));
}

function recordOf(rows) {
  return make("section", { id: "record" }, make("h2", {}, "Record"), table(["name", "value"], rows));
}

async function main() {
  const data = JSON.parse(document.getElementById("data").textContent);
  explain(data.terms);
  document.title = data.title;
  const view = data.mission ? new FlightView(data.mission) : null, screen = data.first ? new Screen(data, view) : null;
  const only = screen ? null : (data.shown || []).map((each) => each.flight).find(Boolean);
  const sections = [];
  if (screen) sections.push(["weaknesses", "Goals", screen.element]);
  if (only) sections.push(["flight", "The flight", view.element]);
  if (screen || only) sections.push(["numbers-of-the-flight", "The flight in numbers", view.details]);
  if (data.shown) sections.push(["flown", data.heading, flownOf(data)]);
  (data.tables || []).forEach((each, k) => sections.push([`table-${k + 1}`, each.title, make("section", { id: `table-${k + 1}` }, titled(each))]));
  if (data.search) sections.push(["search", "Search", searchOf(data.search)]);
  if (data.evaluations) sections.push(["evaluations", "Evaluations", evaluationsOf(data.evaluations)]);
  sections.push(["record", "Record", recordOf(data.record)]);
  const links = sections.map(([id, label]) => make("li", {}, make("a", { href: `#${id}` }, label)));
  document.body.append(
    make("header", {}, screen ? screen.header() : make("h1", {}, bdi(data.title))),
    make("main", {}, sections.map(([, , element]) => element)),
    make("footer", { class: "note" }, make("nav", { "aria-label": "sections" }, make("ul", {}, links)),
      "Keys: space plays or pauses; ← and → move by one tick, with shift by ten; n and p go to the next or previous event; f follows robots; Home and End go to the first or last tick. CI: collective intelligence."));
  if (only) await view.show(only);
  if (screen) await screen.followLink();
  document.documentElement.dataset.ready = "true";
}

main();
