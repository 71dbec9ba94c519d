// One flight: map, controls, timeline and charts on the same ticks.

const palette = ["#1b6ca8", "#d9622b", "#2a8c6a", "#8a5aa8", "#b8902a", "#c2476f", "#3a8fb7", "#5b6b2f"]; // as in the figures

const believedTrail = 50; // ticks; longer trails of random positions would hide the mission

// The distance of a point from the edges of a polygon, negative inside; as mrsfi_runtime.model.polygons.
function offPolygon(corners, x, y) {
  let least = Infinity, inside = false, [ax, ay] = corners[corners.length - 1];
  for (const [bx, by] of corners) {
    const [ex, ey, dx, dy] = [bx - ax, by - ay, x - ax, y - ay], share = Math.min(Math.max((dx * ex + dy * ey) / (ex * ex + ey * ey), 0), 1);
    least = Math.min(least, Math.hypot(share * ex - dx, share * ey - dy));
    if ((ay > y) !== (by > y) && (ex * dy > ey * dx) === (ey > 0)) inside = !inside;
    [ax, ay] = [bx, by];
  }
  return inside ? -least : least;
}

class Flight {
  constructor(data, mission) {
    Object.assign(this, data);
    this.mission = mission;
  }

  async load() {
    const n = this.mission.robots.length, series = {};
    for (const [name, text] of Object.entries(this.packed)) {
      series[name] = await unpack(text, n, this.steps[name]);
    }
    for (const name of Object.keys(series)) {
      const truth = series[name.replace("believed_", "")];
      if (name.startsWith("believed_")) for (let k = 0; k < truth.length; k++) series[name][k] += truth[k];
    }
    this.series = series;
    return this;
  }

  // A value of a robot at a tick, interpolated between the ticks of the page.
  at(name, robot, tick) {
    const n = this.mission.robots.length, values = this.series[name], place = tick / this.stride;
    const last = values.length / n - 1, low = Math.min(Math.floor(place), last), high = Math.min(low + 1, last);
    const end = Math.min(high * this.stride, this.mission.duration - 1), begin = low * this.stride;
    const share = end > begin ? (tick - begin) / (end - begin) : 0;
    return values[low * n + robot] * (1 - share) + values[high * n + robot] * share;
  }
}

class FlightView {
  constructor(mission, faultFree) {
    this.mission = mission;
    this.faultFree = faultFree; // packed; the flight without a single fault
    this.tick = 0;
    this.speed = 4;
    this.playing = false;
    this.follows = false;
    this.resetMap();
    this.element = make("div", { id: "flight" });
    this.details = make("section", { id: "numbers-of-the-flight" });
    document.addEventListener("keydown", (event) => this.onKey(event));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (this.data) this.show(this.data); });
    addEventListener("resize", () => { if (this.flight) this.resize(); });
  }

  resetMap() {
    this.zoom = 1;
    this.shift = [0, 0];
  }

  async show(data, without) {
    if (data !== this.data) this.tick = data.first;
    this.data = data;
    const flight = await new Flight(data.flights[0], this.mission).load(), samples = [];
    const found = without === undefined || without === null ? null : data.flights.find((each) => each.without === without);
    const other = found ? await new Flight(found.packed ? found : await opened(this.faultFree), this.mission).load() : null;
    for (const [goal, step, text] of data.samples) {
      const places = await unpack(text, 3, 1);
      for (let k = 0; k < places.length; k += 3) samples.push([places[k], goal, places[k + 1] * step, places[k + 2] * step]);
    }
    if (data !== this.data) return;
    Object.assign(this, { flight, other, samples });
    this.without = this.other ? without : null;
    this.events = data.events;
    this.build();
    this.resize();
    document.documentElement.dataset.ready = "true";
  }

  build() {
    const { mission, data } = this, last = mission.duration - 1;
    const button = (label, title, act, more) => make("button", { type: "button", title, "aria-label": title, on: { click: act }, ...more }, label);
    this.canvas = make("canvas", { role: "img", "aria-label": "map of the mission with true and believed positions" });
    this.slider = make("input", { type: "range", min: 0, max: last, value: this.tick, "aria-label": "tick", id: "tick",
      on: { input: () => this.seek(Number(this.slider.value)) } });
    this.play = button("Play", "play or pause (space)", () => this.toggle(), { id: "play" });
    this.now = make("output", { id: "now" });
    this.event = make("p", { class: "note", id: "event", role: "status" });
    this.hover = make("p", { class: "note", id: "hover" }, "Point at a robot or an obstacle to see its numbers.");
    this.numbers = make("div");
    const speeds = make("select", { "aria-label": "ticks a frame", id: "speed", on: { change: (event) => { this.speed = Number(event.target.value); } } },
      [0.25, 0.5, 1, 2, 4, 8, 16].map((n) => make("option", { value: n, selected: n === this.speed }, `× ${n}`)));
    this.following = button("Follow", "follow the robots that the faults affect, or show the whole area (f)", () => this.follow(), { id: "follow", "aria-pressed": String(this.follows) });
    this.timeline = make("div", { class: "timeline" });
    this.charts = make("div", { class: "side" });
    this.element.replaceChildren(
      make("div", { class: "map" }, this.canvas, make("div", { class: "zoom" }, this.following, button("+", "zoom in", () => this.zoomBy(1.5)), button("−", "zoom out", () => this.zoomBy(1 / 1.5)))),
      this.hover, this.timeline,
      make("div", { class: "controls" },
        this.play, button("‹ event", "previous event (p)", () => this.jump(-1), { id: "previous" }), button("−1", "one tick back (←)", () => this.seek(this.tick - 1)),
        this.slider, button("+1", "one tick on (→)", () => this.seek(this.tick + 1), { id: "step" }),
        button("event ›", "next event (n)", () => this.jump(1), { id: "next" }), speeds, this.now),
      this.event);
    this.details.replaceChildren(
      make("h2", {}, "The flight in numbers"),
      make("p", { class: "note" }, bdi("Filled discs and solid lines show true positions. " +
        `Dashed circles and lines (of the last ${believedTrail} ticks) show believed positions; a line joins the two where they differ. Dots are samples that counted. ` +
        "A black line in the timeline marks the tick from which on a goal fails. Click a fault to add the flight without it, in pale colours.")),
      this.numbers, this.charts, make("p", { class: "note", id: "resolution" }, data.said));
    this.canvas.addEventListener("pointermove", (event) => this.onPointer(event));
    this.canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoomBy(event.deltaY < 0 ? 1.2 : 1 / 1.2, event); }, { passive: false });
    this.buildTimeline();
    this.buildCharts();
    withTerms(this.timeline);
    withTerms(this.details);
  }

  follow() {
    this.follows = !this.follows;
    this.following.setAttribute("aria-pressed", String(this.follows));
    this.resetMap();
    this.draw();
  }

  buildTimeline() {
    const total = this.mission.duration, share = (tick) => `${(100 * tick) / total}%`;
    const bar = (kind, first, last, title) => {
      const element = make("div", { class: `bar ${kind}`, title });
      element.style.left = share(first);
      element.style.width = share(last + 1 - first);
      return element;
    };
    const track = (...bars) => make("div", { class: "track", on: { click: (event) => {
      const box = event.currentTarget.getBoundingClientRect();
      this.seek(Math.floor(((event.clientX - box.left) / box.width) * total));
    } } }, bars);
    const faults = this.data.faults.map((fault, k) => {
      const can = this.data.flights.some((each) => each.without === k);
      const label = make("button", { type: "button", class: "fault", disabled: !can, "aria-pressed": String(this.without === k),
        title: can ? "show or hide the flight without this fault" : null,
        on: { click: () => this.show(this.data, this.without === k ? null : k) } }, bdi(`${fault.name} ${fault.type}`));
      const title = `${fault.name} ${fault.type} on ${fault.target}${fault.values ? ` with ${fault.values}` : ""}`;
      return make("div", { class: "row" }, label, track(...(fault.waits ? [bar("fault waiting", ...fault.waits, title)] : []), ...(fault.window ? [bar("fault", ...fault.window, title)] : [])));
    });
    const concerned = this.mission.goals.map((goal, k) => [goal, k]).filter(([goal, k]) => {
      const judged = this.flight.goals[k];
      return goal.id === this.data.goal || judged.missed !== null || judged.believed.length || judged.true.length;
    });
    const goals = concerned.sort(([a], [b]) => (b.id === this.data.goal) - (a.id === this.data.goal)).map(([goal, k]) => {
      const judged = this.flight.goals[k];
      const bars = ["believed", "true"].flatMap((kind) => judged[kind].map(([first, last]) => bar(kind, first, last, `${goal.id} violated in ${kind === "true" ? "truth" : "belief"}, ticks ${first} to ${last}`)));
      if (judged.missed !== null) bars.push(bar("missed", judged.missed, judged.missed, `${goal.id} fails from tick ${judged.missed} on: it can no longer be met`));
      return make("div", { class: "row" }, make("span", { title: goal.name }, bdi(goal.label === goal.id ? goal.id : `${goal.label} (${goal.id})`)), track(...bars));
    });
    this.cursor = make("div", { class: "cursor" });
    this.timeline.replaceChildren(...faults, ...goals, this.cursor, make("p", { class: "note keys" },
      make("span", { class: "key fault" }), bdi("fault active"), make("span", { class: "key believed" }), bdi("violated in belief"), make("span", { class: "key true" }), bdi("violated in truth"),
      make("span", { class: "key missed" }), bdi("goal fails")));
  }

  buildCharts() {
    const { mission, flight } = this, ticks = [];
    for (let tick = 0; tick < mission.duration; tick += flight.stride) ticks.push(tick);
    if (ticks[ticks.length - 1] !== mission.duration - 1) ticks.push(mission.duration - 1);
    const ink = colour("ink"), grid = colour("grid");
    this.plots = ["speed", "energy"].map((name) => {
      const place = make("div");
      this.charts.append(place);
      const series = mission.robots.flatMap((robot, r) => [false, true].map((believed) => ({
        label: `${robot.id} ${believed ? "believed" : "true"}`, stroke: palette[r % palette.length], width: 1.5, dash: believed ? [6, 4] : undefined, points: { show: false } })));
      const values = mission.robots.flatMap((_, r) => ["", "believed_"].map((side) => ticks.map((tick) => flight.at(side + name, r, tick))));
      return new uPlot({ title: this.labelled(name), width: 500, height: 190, scales: { x: { time: false } }, legend: { show: mission.robots.length <= 4, live: false },
        axes: [{ stroke: ink, grid: { stroke: grid } }, { stroke: ink, grid: { stroke: grid }, size: 72 }], series: [{ label: "tick" }, ...series] }, [ticks, ...values], place);
    });
  }

  // A label with the unit of the model, if it has one.
  labelled(name) {
    const unit = this.mission.units[name];
    return unit ? `${name} (${unit})` : name;
  }

  withUnit(distance) {
    return `${distance} ${this.mission.units.x}`.trimEnd();
  }

  place(x, y) {
    return this.withUnit(`(${number(x)}, ${number(y)})`);
  }

  resize() {
    const ratio = devicePixelRatio || 1, width = this.canvas.clientWidth || 600;
    this.canvas.width = width * ratio;
    this.canvas.height = Math.round(width * 0.46 * ratio);
    for (const plot of this.plots) plot.setSize({ width: Math.max(240, plot.root.parentElement.clientWidth - 8), height: 190 });
    this.draw();
  }

  // The point on the canvas of a point of the mission, in which y grows upwards.
  project(x, y) {
    const [cx, cy, half] = this.follows ? this.concerned() : this.data.window;
    const scale = (Math.min(this.canvas.width, this.canvas.height) / 2 / half) * this.zoom;
    return [this.canvas.width / 2 + (x - cx + this.shift[0]) * scale, this.canvas.height / 2 - (y - cy + this.shift[1]) * scale, scale];
  }

  // The square around true and believed positions of the robots that faults affect.
  concerned() {
    const robots = this.data.robots.length ? this.data.robots : this.mission.robots.map((_, r) => r);
    const xs = robots.flatMap((r) => ["x", "believed_x"].map((name) => this.flight.at(name, r, this.tick)));
    const ys = robots.flatMap((r) => ["y", "believed_y"].map((name) => this.flight.at(name, r, this.tick)));
    const middle = (values) => (Math.min(...values) + Math.max(...values)) / 2, reach = (values) => Math.max(...values) - Math.min(...values);
    return [middle(xs), middle(ys), Math.max(reach(xs), reach(ys)) * 0.7 + this.data.window[2] * 0.15];
  }

  draw() {
    const context = this.canvas.getContext("2d"), ratio = devicePixelRatio || 1, { mission, tick } = this;
    const began = performance.now();
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.spots = [];
    const disc = (x, y, radius, { fill, stroke, dash = [], width = 1, least = 0, corners }) => {
      const [px, py, scale] = this.project(x, y);
      context.beginPath();
      if (corners) { for (const [dx, dy] of corners) context.lineTo(...this.project(x + dx, y + dy).slice(0, 2)); context.closePath(); }
      else context.arc(px, py, Math.max(radius * scale, least * ratio), 0, 2 * Math.PI);
      if (fill) { context.fillStyle = fill; context.fill(); }
      if (stroke) { context.strokeStyle = stroke; context.setLineDash(dash.map((d) => d * ratio)); context.lineWidth = width * ratio; context.stroke(); context.setLineDash([]); }
      return [px, py];
    };
    const labels = [];
    const label = (text, px, py, style) => labels.push([text.slice(0, 24), px + 8 * ratio, py - 6 * ratio, style]);
    disc(...mission.area, { stroke: colour("soft"), width: 1.5 });
    for (const area of mission.discs) { const [px, py] = disc(area.x, area.y, area.radius, { stroke: colour("true"), dash: [3, 3], corners: area.corners }); label(area.goal, px, py, colour("soft")); }
    mission.obstacles.forEach((obstacle) => {
      const [px, py] = disc(obstacle.x, obstacle.y, obstacle.radius, { fill: colour("rock"), corners: obstacle.corners });
      this.spots.push([px, py, `${obstacle.id}: obstacle at ${this.place(obstacle.x, obstacle.y)}, ${obstacle.corners ? `${obstacle.corners.length} corners` : `radius ${this.withUnit(number(obstacle.radius))}`}`]);
    });
    for (const [from, to, x, y, id, radius] of this.data.displaced) if (from <= tick && tick <= to) {
      const { corners } = mission.obstacles.find((each) => each.id === id);
      const [px, py] = disc(x, y, radius, { stroke: colour("believed"), dash: [4, 3], corners });
      this.spots.push([px, py, `${id}: obstacle believed at ${this.place(x, y)}`]);
    }
    for (const [at, goal, x, y] of this.samples) if (at <= tick) disc(x, y, 0, { fill: colour("true"), least: 1.5 });
    if (this.other) this.drawRobots(context, this.other, disc, null, 0.35);
    this.drawRobots(context, this.flight, disc, label, 1);
    this.drawLabels(context, labels.reverse());
    this.showTick(performance.now() - began);
  }

  // Labels that have room; earlier ones come first.
  drawLabels(context, labels) {
    const ratio = devicePixelRatio || 1, height = 13 * ratio, taken = [];
    context.font = `${12 * ratio}px system-ui, sans-serif`;
    for (const [text, x, y, style] of labels) {
      const width = context.measureText(text).width;
      if (taken.some(([a, b, w]) => Math.abs(b - y) < height && x < a + w && a < x + width)) continue;
      taken.push([x, y, width]);
      context.fillStyle = style;
      context.fillText(text, x, y);
    }
  }

  drawRobots(context, flight, disc, label, alpha) {
    const { mission, tick } = this, ratio = devicePixelRatio || 1;
    context.globalAlpha = alpha;
    mission.robots.forEach((robot, r) => {
      const shade = palette[r % palette.length], at = (name, t) => flight.at(name, r, t);
      for (const side of ["", "believed_"]) {
        context.beginPath();
        const first = side ? Math.max(0, tick - believedTrail) : 0;
        for (let t = first; t <= tick; t += Math.max(flight.stride, Math.ceil(tick / 1500))) {
          const [px, py] = this.project(at(`${side}x`, t), at(`${side}y`, t));
          if (t === first) context.moveTo(px, py); else context.lineTo(px, py);
        }
        context.lineTo(...this.project(at(`${side}x`, tick), at(`${side}y`, tick)).slice(0, 2));
        context.strokeStyle = shade; context.lineWidth = (side ? 0.7 : 1.6) * ratio; context.setLineDash(side ? [3 * ratio, 4 * ratio] : []);
        context.stroke(); context.setLineDash([]);
      }
      const [x, y, bx, by] = ["x", "y", "believed_x", "believed_y"].map((name) => at(name, tick));
      if (x !== bx || y !== by) {
        context.beginPath(); context.moveTo(...this.project(x, y).slice(0, 2)); context.lineTo(...this.project(bx, by).slice(0, 2));
        context.strokeStyle = colour("believed"); context.lineWidth = 1.2 * ratio; context.stroke();
        disc(bx, by, robot.radius, { stroke: shade, dash: [2, 2], width: 1.5, least: 6 });
      }
      const hit = this.touches(flight, r, x, y);
      const [px, py] = disc(x, y, robot.radius, { fill: shade, least: 4, stroke: hit ? colour("fault") : null, width: 4 });
      if (label) { label(robot.name || robot.id, px, py, colour("ink")); this.spots.push([px, py, `${robot.id}: true ${this.place(x, y)}, believed ${this.place(bx, by)}${hit ? ", in collision" : ""}`]); }
    });
    context.globalAlpha = 1;
  }

  touches(flight, robot, x, y) {
    const { mission, tick } = this, { radius } = mission.robots[robot];
    return mission.obstacles.some((each) => (each.corners ? offPolygon(each.corners, x - each.x, y - each.y) : Math.hypot(x - each.x, y - each.y) - each.radius) < radius)
      || (mission.robots.length <= 200 && mission.robots.some((each, r) => r !== robot && Math.hypot(x - flight.at("x", r, tick), y - flight.at("y", r, tick)) < each.radius + radius));
  }

  showTick(milliseconds) {
    const { mission, tick, flight } = this;
    this.slider.value = tick;
    this.now.textContent = `tick ${Math.floor(tick)} of ${mission.duration}`;
    const tracks = this.timeline.querySelector(".track");
    if (tracks) this.cursor.style.left = `${tracks.offsetLeft + (tracks.offsetWidth * (tick + 0.5)) / mission.duration}px`;
    this.element.dataset.frame = milliseconds.toFixed(2);
    const rows = mission.robots.map((robot, r) => [bdi(robot.id), ...["x", "y", "speed", "energy"].flatMap((name) => [flight.at(name, r, tick), flight.at(`believed_${name}`, r, tick)].map((value) => value.toFixed(flight.digits[name])))]);
    const header = ["robot", ...["x", "y", "speed", "energy"].flatMap((name) => [this.labelled(name), "believed"])];
    if (!this.playing || mission.robots.length <= 12) this.numbers.replaceChildren(withTerms(table(header, rows, { id: "numbers" })));
  }

  seek(tick) {
    this.tick = Math.max(0, Math.min(this.mission.duration - 1, tick));
    this.draw();
  }

  jump(direction) {
    const ahead = this.events.filter(([tick]) => (direction > 0 ? tick > this.tick : tick < this.tick));
    const found = direction > 0 ? ahead[0] : ahead[ahead.length - 1];
    if (!found) return;
    this.seek(found[0]);
    const texts = this.events.filter(([tick]) => tick === found[0]).map(([, text]) => text);
    this.event.textContent = `tick ${found[0]}: ${texts.join("; ")}`;
  }

  // With an event, the point under the pointer stays where it is.
  zoomBy(factor, event) {
    const box = this.canvas.getBoundingClientRect(), ratio = this.canvas.width / box.width, before = this.project(0, 0)[2];
    this.zoom = Math.max(0.2, Math.min(200, this.zoom * factor));
    const change = 1 / this.project(0, 0)[2] - 1 / before;
    if (event) this.shift = [this.shift[0] + ((event.clientX - box.left) * ratio - this.canvas.width / 2) * change, this.shift[1] - ((event.clientY - box.top) * ratio - this.canvas.height / 2) * change];
    this.draw();
  }

  toggle() {
    this.playing = !this.playing;
    this.play.textContent = this.playing ? "Pause" : "Play";
    if (this.playing && this.tick >= this.mission.duration - 1) this.tick = 0;
    const frame = () => {
      if (!this.playing) return;
      this.seek(this.tick + this.speed);
      if (this.tick >= this.mission.duration - 1) this.toggle(); else requestAnimationFrame(frame);
    };
    if (this.playing) requestAnimationFrame(frame); else this.draw();
  }

  onKey(event) {
    if (!this.flight || event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range") return;
    const onButton = event.target.tagName === "BUTTON";
    const act = { " ": onButton ? null : () => this.toggle(), ArrowRight: () => this.seek(this.tick + (event.shiftKey ? 10 : 1)),
      ArrowLeft: () => this.seek(this.tick - (event.shiftKey ? 10 : 1)), Home: () => this.seek(0), End: () => this.seek(this.mission.duration - 1),
      n: () => this.jump(1), p: () => this.jump(-1), f: () => this.follow() }[event.key];
    if (act) { event.preventDefault(); act(); }
  }

  onPointer(event) {
    const box = this.canvas.getBoundingClientRect(), ratio = this.canvas.width / box.width;
    const [x, y] = [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio];
    if (event.buttons) {
      const [, , scale] = this.project(0, 0);
      this.shift = [this.shift[0] + (event.movementX * ratio) / scale, this.shift[1] - (event.movementY * ratio) / scale];
      this.draw();
    }
    const near = this.spots.map(([px, py, text]) => [Math.hypot(px - x, py - y), text]).sort((a, b) => a[0] - b[0])[0];
    if (near && near[0] < 20 * ratio) this.hover.replaceChildren(bdi(near[1]));
  }
}
