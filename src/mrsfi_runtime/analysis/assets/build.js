"use strict";
// Elements of the page. Text of a model stays text: no markup is parsed anywhere.

function make(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === "on") for (const [event, act] of Object.entries(value)) element.addEventListener(event, act);
    else if (value !== null && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat(2)) if (child !== null) element.append(child);
  return element;
}

const longest = 300; // letters; longer text scrolls on its own

// Text of any direction.
const bdi = (text) => make("bdi", String(text).length > longest ? { dir: "auto", class: "long", tabindex: "0" } : { dir: "auto" }, String(text));

const meanings = new Map();
let anyTerm = /(?!)/g;

function explain(terms) {
  for (const [word, meaning] of Object.entries(terms)) meanings.set(word.toLowerCase(), meaning);
  const words = [...meanings.keys()].sort((a, b) => b.length - a.length);
  anyTerm = new RegExp(`\\b(${words.join("|")})(?:e?s)?\\b`, "gi");
}

const unexplained = "h1, h2, h3, button, code, pre, a, abbr, summary, option, output, small, canvas, .uplot, td:not(#goals td)";

// Give terms tooltips where each first stands in the prose of a part of the page.
function withTerms(element) {
  const terms = new Set(), texts = [], walker = document.createTreeWalker(element, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) if (!walker.currentNode.parentElement.closest(unexplained)) texts.push(walker.currentNode);
  for (const text of texts) text.replaceWith(...explained(text.data, terms));
  return element;
}

const meaningOf = (words) => [...words.matchAll(anyTerm)].map((match) => meanings.get(match[1].toLowerCase()))[0] || null;

function explained(text, terms) {
  const parts = [];
  let end = 0;
  for (const match of text.matchAll(anyTerm)) {
    const title = meanings.get(match[1].toLowerCase());
    if (terms.has(title)) continue;
    terms.add(title);
    parts.push(text.slice(end, match.index), make("abbr", { title, tabindex: "0" }, match[0]));
    end = match.index + match[0].length;
  }
  return [...parts, text.slice(end)];
}

function number(value) {
  if (value === null || value === undefined) return "–";
  if (typeof value !== "number") return bdi(value);
  return Number.isInteger(value) ? String(value) : value.toFixed(Math.abs(value) < 1 ? 4 : 2);
}

let nTables = 0; // each table is a landmark with its own name

function table(header, rows, attributes) {
  const numeric = header.map((_, k) => rows.length > 0 && rows.every((row) => row[k] === null || typeof row[k] === "number"));
  const cell = (tag, value, k) => make(tag, { class: numeric[k] ? "number" : null }, tag === "th" ? bdi(value) : value instanceof Node ? value : number(value));
  return make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": `table ${(nTables += 1)}` },
    make("table", attributes || {},
      make("thead", {}, make("tr", {}, header.map((value, k) => cell("th", value, k)))),
      make("tbody", {}, rows.map((row) => make("tr", {}, row.map((value, k) => cell("td", value, k)))))));
}

const titled = ({ title, header, rows }) => [make("p", { class: "note" }, bdi(title)), table(header, rows)];

function copying(text) {
  const button = make("button", { type: "button" }, "Copy");
  button.addEventListener("click", async () => {
    try { await navigator.clipboard.writeText(text); } catch {
      const area = make("textarea", {}, text);
      document.body.append(area); area.select(); document.execCommand("copy"); area.remove();
    }
    button.textContent = "Copied";
  });
  return button;
}

const commandOf = (what, command) => make("div", { class: "command" }, make("span", {}, what), make("code", {}, bdi(command)), copying(command));

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
}

async function inflated(text) {
  const raw = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Plain values, which are read only when they are shown.
const opened = async (text) => JSON.parse(new TextDecoder().decode(await inflated(text)));

// Series of a flight: 32-bit differences from tick to tick, lowest bytes of all first, in zlib.
async function unpack(text, columns, step) {
  const bytes = await inflated(text), n = bytes.length / 4, values = new Float64Array(n), sums = new Int32Array(columns);
  for (let k = 0; k < n; k++) {
    sums[k % columns] += bytes[k] | (bytes[n + k] << 8) | (bytes[2 * n + k] << 16) | (bytes[3 * n + k] << 24);
    values[k] = sums[k % columns] * step;
  }
  return values;
}
