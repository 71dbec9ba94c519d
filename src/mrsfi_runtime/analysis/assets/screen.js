// The first screen: goals with their weaknesses and evidence, and beside them the flight.

class Screen {
  constructor(data, view) {
    Object.assign(this, data.first);
    this.shown = data.shown;
    this.view = view;
    this.panel = make("div", { id: "panel", "aria-live": "polite" });
    this.next = make("div", { id: "next" });
    this.buttons = new Map();
    this.element = make("div", { id: "weaknesses", class: "screen" },
      make("div", { class: "left" }, this.goalsOf(), this.matrix ? this.matrixOf() : null),
      make("div", { class: "right" }, this.panel, view.element, this.next));
    addEventListener("hashchange", () => this.followLink());
  }

  header() {
    const terms = new Set();
    return make("div", { class: "head" },
      make("div", {}, make("h1", {}, bdi(this.headline)), make("p", { class: "note" }, bdi(this.about))),
      make("ul", {}, this.facts.map((fact) => make("li", {}, bdi(fact, terms)))));
  }

  goalsOf() {
    const terms = new Set(), heads = ["", "Goal and its main weakness", "Evidence"];
    return make("table", { id: "goals" },
      make("thead", {}, make("tr", {}, heads.map((each) => make("th", { scope: "col" }, each ? bdi(each, terms) : make("span", { class: "hidden" }, "state"))))),
      make("tbody", {}, this.goals.map((goal) => {
        const chosen = goal.number ? this.choosing(goal.number, bdi(goal.name)) : make("b", {}, bdi(goal.name));
        const row = make("tr", { class: goal.grave ? "grave" : null, "data-goal": goal.id },
          make("td", { class: "state", title: goal.state }, goal.mark),
          make("td", {}, make("div", { class: "flowing" }, chosen, " ", goal.id === goal.name ? "" : make("small", {}, bdi(`(${goal.id})`)), " ", make("b", { class: "verdict" }, bdi(goal.state, terms)), goal.cause ? [" ", bdi(goal.cause)] : "", ". ", goal.detection ? [bdi(goal.detection, terms), "."] : "")),
          make("td", {}, goal.stakes ? make("div", {}, bdi(`${goal.stakes}.`, terms)) : null, bdi(goal.evidence, terms)));
        if (goal.number) row.addEventListener("click", () => this.choose(goal.number));
        return row;
      })));
  }

  choosing(number, label, more) {
    const button = make("button", { type: "button", ...more, on: { click: (event) => { event.stopPropagation(); this.choose(number); } } }, label);
    this.buttons.set(number, [...(this.buttons.get(number) || []), button]);
    return button;
  }

  matrixOf() {
    const { owners, faults, rows, note } = this.matrix, terms = new Set();
    const cell = (number) => {
      const each = this.ways.find((way) => way.number === number);
      if (!each) return make("td", { class: "none" });
      const bar = make("span", { class: `share ${each.kind}${each.undetected ? " undetected" : ""}` });
      bar.style.height = `${Math.max(12, 100 * each.share)}%`;
      return make("td", {}, this.choosing(each.number, [bar, each.joint ? make("i", {}, "+") : null], { class: "cell", title: each.said, "aria-label": each.said }));
    };
    return make("section", { id: "matrix" }, make("h2", {}, "Which fault breaks which goal"),
      make("p", { class: "note keys" }, make("span", { class: "key share undetected" }), bdi("broken, undetected in at least one variant", terms), make("span", { class: "key share" }), bdi("broken, detected in all variants", terms),
        make("span", { class: "key share believed" }), bdi("false alarm only. Height: share of variants. +: only together with other faults", terms)),
      make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "which fault breaks which goal" }, make("table", {},
        make("thead", {},
          make("tr", {}, make("td"), owners.map((owner) => make("th", { colspan: owner.n, scope: "colgroup" }, bdi(owner.name)))),
          make("tr", {}, make("td"), faults.map((fault) => make("th", { scope: "col", class: "turned", title: fault.title }, make("span", {}, bdi(fault.label)))))),
        make("tbody", {}, rows.map((row) => make("tr", {}, make("th", { scope: "row" }, bdi(row.name), row.id === row.name ? null : [" ", make("small", {}, bdi(`(${row.id})`))]), row.cells.map(cell)))))),
      make("p", { class: "note" }, bdi(note, terms)));
  }

  async choose(number, keep) {
    const way = this.ways.find((each) => each.number === number), terms = new Set();
    for (const [key, buttons] of this.buttons) buttons.forEach((each) => each.setAttribute("aria-pressed", String(key === number)));
    for (const row of this.element.querySelectorAll("#goals tbody tr")) row.classList.toggle("chosen", row.dataset.goal === way.goal);
    if (!keep) history.replaceState(null, "", `#weakness-${number}`);
    const shown = way.shown === null ? null : this.shown[way.shown];
    const why = shown && shown.flight ? "" : shown ? shown.no_flight : "This page does not include its flight. The first command below draws it.";
    this.panel.replaceChildren(make("h2", { id: "flight-title" }, bdi(way.name), " ", make("small", {}, bdi(`${way.goal === way.name ? "" : `(${way.goal}) · `}weakness ${number}`))),
      make("p", {}, bdi(`${way.said}.`, terms)), make("p", { class: "note" }, bdi(`${way.sure}. ${why}`, terms)));
    this.next.replaceChildren(make("h3", {}, "Next"), ...way.next.map(([what, command]) => make("div", { class: "command" }, make("span", {}, what), make("code", {}, bdi(command)), copying(command))));
    const flight = shown ? shown.flight : null;
    this.view.element.hidden = this.view.details.hidden = !flight;
    if (flight) await this.view.show(flight);
  }

  // A link such as #weakness-6 shows a weakness; other links lead to sections.
  async followLink() {
    const number = Number((/^#weakness-(\d+)$/.exec(location.hash) || [])[1]);
    const first = this.goals.find((each) => each.number);
    if (this.ways.some((each) => each.number === number)) await this.choose(number, true);
    else if (first && !this.panel.hasChildNodes()) await this.choose(first.number, true);
    else if (!first) this.view.element.hidden = this.view.details.hidden = true;
  }
}
