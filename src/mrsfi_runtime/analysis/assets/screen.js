// The first screen: goals with their weaknesses and evidence, and beside them the flight.

const classes = { never: ["●", "undetected in at least one variant"], late: ["◐", "detected too late in at least one"], "in-time": ["○", "detected in time in all"], unknown: ["?", "detection not recorded"], alarm: ["△", "false alarm only"] };

// The mark of a class, readable without colour, above a box filled up to a share.
function classMark(name, share, isJoint) {
  const bar = make("b"), box = make("span", { class: `class ${name}`, "aria-hidden": "true" }, make("span", {}, classes[name][0] + (isJoint ? "+" : "")), make("em", {}, bar));
  bar.style.height = `${100 * share}%`;
  return box;
}

class Screen {
  constructor(data, view, show) {
    Object.assign(this, data.first, { shown: data.shown || {}, view, show });
    this.panel = make("div", { id: "panel", "aria-live": "polite" });
    this.next = make("div", { id: "next" });
    this.buttons = new Map();
    this.element = make("div", { id: "weaknesses", class: "screen" },
      make("div", { class: "left" }, this.goalsOf(), this.matrix ? this.matrixOf() : null, this.monitors ? this.monitorsOf() : null),
      make("div", { class: "right" }, this.panel, view.element, this.next));
  }

  header() {
    return withTerms(make("div", { class: "head" },
      make("div", {}, make("h1", {}, bdi(this.headline)), make("p", { class: "note" }, bdi(this.about))),
      make("ul", {}, this.facts.map((fact) => make("li", {}, bdi(fact))))));
  }

  goalsOf() {
    const heads = ["", "Goal and its main weakness", "Evidence"];
    return withTerms(make("table", { id: "goals" },
      make("thead", {}, make("tr", {}, heads.map((each) => make("th", { scope: "col" }, each ? bdi(each) : make("span", { class: "hidden" }, "state"))))),
      make("tbody", {}, this.goals.map((goal) => {
        const chosen = goal.number ? this.choosing(goal.number, bdi(goal.name)) : make("b", {}, bdi(goal.name));
        const row = make("tr", { class: goal.grave ? "grave" : null, "data-goal": goal.id },
          make("td", { class: "state", title: goal.state }, goal.mark),
          make("td", {}, make("div", { class: "flowing" }, chosen, " ", goal.id === goal.name ? "" : make("small", {}, bdi(`(${goal.id})`)), " ", make("b", { class: "verdict" }, bdi(goal.state)), goal.cause ? [" ", bdi(goal.cause)] : "", ". ", goal.detection ? [bdi(goal.detection), "."] : ""),
            goal.known.map((line) => make("div", { class: "known" }, bdi(line)))),
          make("td", {}, goal.stakes ? make("div", {}, bdi(`${goal.stakes}.`)) : null, bdi(goal.evidence)));
        if (goal.number) row.addEventListener("click", () => this.choose(goal.number));
        return row;
      }))));
  }

  choosing(number, label, more) {
    const button = make("button", { type: "button", ...more, on: { click: (event) => { event.stopPropagation(); this.choose(number); } } }, label);
    this.buttons.set(number, [...(this.buttons.get(number) || []), button]);
    return button;
  }

  matrixOf() {
    const { owners, faults, rows, note } = this.matrix;
    const cell = (number) => {
      const each = this.ways.find((way) => way.number === number);
      if (!each) return make("td", { class: "none" });
      return make("td", {}, this.choosing(each.number, [classMark(each.class, each.share, each.joint)], { class: "cell", title: each.said, "aria-label": each.said }));
    };
    return withTerms(make("section", { id: "matrix" }, make("h2", {}, "Which fault breaks which goal"),
      make("p", { class: "note keys" }, Object.entries(classes).filter(([name]) => this.ways.some((way) => way.class === name)).map(([name, [, words]]) => make("span", {}, classMark(name, 0.5), bdi(words))),
        make("span", {}, bdi("Filled: share of variants. +: joint, only together with other faults."))),
      make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "which fault breaks which goal" }, make("table", {},
        make("thead", {},
          make("tr", {}, make("td"), owners.map((owner) => make("th", { colspan: owner.n, scope: "colgroup" }, bdi(owner.name)))),
          make("tr", {}, make("td"), faults.map((fault) => make("th", { scope: "col", class: "turned", title: fault.title }, make("span", {}, bdi(fault.label)))))),
        make("tbody", {}, rows.map((row) => make("tr", {}, make("th", { scope: "row" }, bdi(row.name), row.id === row.name ? null : [" ", make("small", {}, bdi(`(${row.id})`))]), row.cells.map(cell)))))),
      make("p", { class: "note" }, bdi(note))));
  }

  monitorsOf() {
    return withTerms(make("section", { id: "monitors" }, make("h2", {}, "Which monitors to add"), ...titled(this.monitors)));
  }

  async choose(number, keep) {
    this.number = number;
    const way = this.ways.find((each) => each.number === number);
    for (const [key, buttons] of this.buttons) buttons.forEach((each) => each.setAttribute("aria-pressed", String(key === number)));
    for (const row of this.element.querySelectorAll("#goals tbody tr")) row.classList.toggle("chosen", row.dataset.goal === way.goal);
    if (!keep && location.hash !== `#w${number}`) history.pushState(null, "", `#w${number}`);
    const shown = this.shown[number] ? await opened(this.shown[number]) : null;
    if (this.number !== number) return;
    const why = shown && shown.flight ? "" : shown ? shown.no_flight : "This page has flights of the gravest weaknesses only. The first two commands below show this one.";
    this.panel.replaceChildren(make("h2", { id: "flight-title" }, bdi(way.name), " ", make("small", {}, bdi(`${way.goal === way.name ? "" : `(${way.goal}) · `}weakness ${number}`))),
      make("p", {}, bdi(`${way.said}.`)), make("p", { class: "note" }, bdi(`${way.sure}. ${why}`)),
      make("p", { class: "decision" }, make("b", {}, "Status: "), bdi(`${way.status}.`)),
      ...(way.mildest ? [make("p", { class: "note" }, bdi(`Mildest variant: ${way.mildest}.`))] : []));
    withTerms(this.panel);
    this.next.replaceChildren(make("h3", {}, "Next"), ...way.next.map((each) => commandOf(...each)));
    if (shown) this.show(shown);
    const flight = shown ? shown.flight : null;
    this.view.element.hidden = this.view.details.hidden = !flight;
    if (flight) await this.view.show(flight);
  }

  // Show a weakness by its number, or the first one if the page begins or is back at its beginning.
  async follow(number) {
    const first = this.goals.find((each) => each.number);
    if (this.ways.some((each) => each.number === number)) await this.choose(number, true);
    else if (first && (!location.hash || !this.panel.hasChildNodes())) await this.choose(first.number, true);
    else if (!first) this.view.element.hidden = this.view.details.hidden = true;
  }
}
