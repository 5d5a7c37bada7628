// What makes the page's plot answer. No library: a plot of points on logarithmic axes is some shapes in an SVG, the
// smallest plotting library is several times this long, and those that are small want one ascending x for all series.
#pragma once

#include <string_view>

namespace farfield::bench {

/// Reads the element `data`, fills the element `plot` and what is around it. Texts from measurements reach the page as
/// text nodes and attributes only.
inline constexpr std::string_view page_script = R"js(
"use strict";
(() => {
  const element = id => document.getElementById(id);
  const { columns, rows, shown } = JSON.parse(element("data").textContent);
  const points = rows.map((values, id) => {
    const point = { id };
    columns.forEach((name, i) => { point[name] = values[i]; });
    point.place = point.scene + ", " + point.view;
    return point;
  });
  const plots = [
    { chart: "accuracy", x: "time_ms", y: "rmse", name: "time against error: RMSE" },
    { chart: "accuracy", x: "time_ms", y: "flip", name: "time against error: FLIP" },
    { chart: "accuracy", x: "hierarchy_bytes", y: "rmse", name: "memory against error: bytes of hierarchy" },
    { chart: "accuracy", x: "touched_bytes", y: "rmse", name: "memory against error: bytes read in a frame" },
    { chart: "growth", x: "triangles", y: "time_ms", name: "triangles against time" },
  ].filter(plot => points.some(point => fits(point, plot)));
  if (plots.length === 0) return;
  function fits(point, plot) { return point.chart === plot.chart && point[plot.x] > 0 && point[plot.y] > 0; }

  const different = (field, of = points) => [...new Set(of.map(point => point[field]))];
  const variants = different("variant");
  const colors = ["#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#7f3c8d", "#8c564b"];
  const dashes = ["", "7 3", "2 3", "9 3 2 3"];
  const colorOf = variant =>
    variant === "peer" ? "#888888" : colors[variants.indexOf(variant) % colors.length];
  const dashOf = variant => dashes[Math.floor(variants.indexOf(variant) / colors.length) % dashes.length];

  // What is switched on. At first one place of each chart, and the variants of its chart at a glance.
  const on = { place: new Set(), variant: new Set(shown), samples: new Set(different("samples")) };
  for (const chart of different("chart")) on.place.add(points.find(point => point.chart === chart).place);
  if (on.variant.size === 0) variants.forEach(variant => on.variant.add(variant));

  let plot = plots[0], pinned = null;
  const svg = element("plot"), width = 900, height = 560, left = 70, right = 15, top = 15, bottom = 50;

  function make(name, parent, attributes = {}, text = "") {
    const isShape = parent.namespaceURI === svg.namespaceURI;
    const made = isShape ? document.createElementNS(svg.namespaceURI, name) : document.createElement(name);
    for (const key of Object.keys(attributes)) made.setAttribute(key, attributes[key]);
    made.textContent = text;
    return parent.appendChild(made);
  }
  const numbers = value => typeof value === "number" ? String(Number(value.toPrecision(4))) : String(value);
  function unit(value) {
    for (const [size, name] of [[1e9, " G"], [1e6, " M"], [1e3, " k"]]) {
      if (value >= size * 0.999) return numbers(value / size) + name;
    }
    return numbers(value);
  }

  function switches(kind, title, values) {
    const box = element(kind + "-switches");
    box.textContent = "";
    make("legend", box, {}, title);
    for (const all of [true, false]) {
      make("button", box, { type: "button" }, all ? "all" : "none").addEventListener("click", () => {
        values.forEach(value => all ? on[kind].add(value) : on[kind].delete(value));
        update();
      });
    }
    for (const value of values) {
      const label = make("label", box);
      const input = make("input", label, { type: "checkbox", value: String(value) });
      input.checked = on[kind].has(value);
      input.addEventListener("change", () => {
        if (input.checked) on[kind].add(value); else on[kind].delete(value);
        draw();
      });
      if (kind === "variant") {
        const dashed = dashOf(value) === "" ? "" : ";mask:repeating-linear-gradient(90deg,#000 0 3px,#0000 3px 5px)";
        make("span", label, { class: "swatch", style: "background:" + colorOf(value) + dashed });
      }
      label.appendChild(document.createTextNode(String(value)));
    }
  }

  function shapeOf(place, x, y, r) {  // places are told apart by shape
    switch (places().indexOf(place) % 4) {
      case 1: return `M${x - r} ${y - r}h${2 * r}v${2 * r}h${-2 * r}z`;
      case 2: return `M${x} ${y - 1.3 * r}l${1.3 * r} ${1.3 * r}l${-1.3 * r} ${1.3 * r}l${-1.3 * r} ${-1.3 * r}z`;
      case 3: return `M${x} ${y - 1.2 * r}l${1.2 * r} ${2.2 * r}h${-2.4 * r}z`;
      default: return `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`;
    }
  }
  const ofPlot = () => points.filter(point => fits(point, plot));
  const places = () => different("place", ofPlot());

  function axis(values, from, to) {
    const room = Math.max(Math.max(...values) / Math.min(...values), 2) ** 0.04;
    const low = Math.log(Math.min(...values) / room), high = Math.log(Math.max(...values) * room);
    const at = value => from + (to - from) * (Math.log(value) - low) / (high - low);
    const digits = high - low > Math.log(2000) ? [1] : [1, 2, 5], ticks = [];
    for (let decade = Math.floor(low / Math.LN10); decade <= high / Math.LN10; ++decade) {
      for (const digit of digits) {
        const value = Number(digit + "e" + decade);
        if (Math.log(value) >= low && Math.log(value) <= high) ticks.push(value);
      }
    }
    return { at, ticks };
  }

  function draw() {
    svg.textContent = "";
    const visible = ofPlot().filter(
      point => on.place.has(point.place) && on.variant.has(point.variant) && on.samples.has(point.samples));
    if (visible.length === 0) {
      make("text", svg, { x: width / 2, y: height / 2, "text-anchor": "middle" }, "nothing is switched on");
      return;
    }
    const x = axis(visible.map(point => point[plot.x]), left, width - right);
    const y = axis(visible.map(point => point[plot.y]), height - bottom, top);
    for (const tick of x.ticks) {
      make("path", svg, { d: `M${x.at(tick)} ${top}V${height - bottom}`, class: "grid" });
      make("text", svg, { x: x.at(tick), y: height - bottom + 18, "text-anchor": "middle" }, unit(tick));
    }
    for (const tick of y.ticks) {
      make("path", svg, { d: `M${left} ${y.at(tick)}H${width - right}`, class: "grid" });
      make("text", svg, { x: left - 8, y: y.at(tick) + 4, "text-anchor": "end" }, unit(tick));
    }
    make("text", svg, { x: width / 2, y: height - 8, "text-anchor": "middle" }, plot.x);
    make("text", svg, { transform: `translate(14 ${height / 2}) rotate(-90)`, "text-anchor": "middle" }, plot.y);
    if (plot.chart === "accuracy") drawFronts(visible, x, y);
    const lines = new Map();
    for (const point of visible) {
      const samples = point.tolerance_px === null && plot.chart === "accuracy" ? "" : point.samples;
      const key = JSON.stringify([point.place, point.variant, samples, point.note]);
      if (!lines.has(key)) lines.set(key, []);
      lines.get(key).push(point);
    }
    const order = point => plot.chart === "growth" ? point.triangles : point.tolerance_px ?? -point.samples;
    for (const line of lines.values()) {
      line.sort((a, b) => order(a) - order(b));
      const d = line.map((point, i) => (i ? "L" : "M") + x.at(point[plot.x]) + " " + y.at(point[plot.y])).join("");
      make("path", svg, { d, class: "line", stroke: colorOf(line[0].variant),
                          "stroke-dasharray": dashOf(line[0].variant) });
    }
    for (const point of visible) {
      const r = 4 + 0.6 * Math.log2(point.samples || 1);
      const mark = make("path", svg, {
        d: shapeOf(point.place, x.at(point[plot.x]), y.at(point[plot.y]), r), class: "point", tabindex: "0",
        role: "img", "aria-label": nameOf(point), fill: colorOf(point.variant), "data-point": String(point.id) });
      mark.addEventListener("mouseenter", () => { if (pinned === null) show(point); });
      mark.addEventListener("focus", () => { if (pinned === null) show(point); });
      mark.addEventListener("click", event => { event.stopPropagation(); pin(point); });
    }
    mark();
  }

  function drawFronts(visible, x, y) {  // of what is switched on, one a place
    for (const place of places()) {
      const sorted = visible.filter(point => point.place === place)
        .sort((a, b) => a[plot.x] - b[plot.x] || a[plot.y] - b[plot.y]);
      let d = "", least = Infinity;
      for (const point of sorted) {
        if (point[plot.y] >= least) continue;
        least = point[plot.y];
        d += d ? `H${x.at(point[plot.x])}V${y.at(least)}` : `M${x.at(point[plot.x])} ${y.at(least)}`;
      }
      if (d) make("path", svg, { d, class: "front" });
    }
  }

  function nameOf(point) {
    const tolerance = point.tolerance_px === null ? "" : ", " + numbers(point.tolerance_px) + " px";
    return point.variant + tolerance + ", " + numbers(point.samples) + (point.samples === 1 ? " sample" : " samples");
  }

  function mark(id = pinned) {
    for (const other of svg.querySelectorAll(".chosen")) other.classList.remove("chosen");
    const chosen = id === null ? null : svg.querySelector(`[data-point="${id}"]`);
    if (chosen) chosen.classList.add("chosen");
  }

  function show(point) {
    const box = element("details");
    box.textContent = "";
    make("h3", box, {}, nameOf(point));
    make("p", box, {}, point.place);
    if (point.chart === "accuracy") {
      for (const [file, text] of [[point.picture, "this"], [point.reference, "reference"]]) {
        if (!file) continue;
        const figure = make("figure", box);
        make("img", figure, { src: file, alt: text });
        make("figcaption", figure, {}, text);
      }
      if (!point.picture) make("p", box, {}, "Its picture does not lie beside this page.");
    }
    const table = make("table", box);
    for (const name of columns) {
      if (["chart", "scene", "view", "variant", "picture", "reference"].includes(name)) continue;
      if (point[name] === null || point[name] === "") continue;
      const row = make("tr", table);
      make("th", row, {}, name);
      make("td", row, {}, numbers(point[name]));
    }
    mark(point.id);
  }

  function pin(point) {
    pinned = point.id;
    show(point);
  }
  function unpin() {
    pinned = null;
    mark();
  }

  function update() {
    switches("place", "scenes", places());
    switches("variant", "variants", different("variant", ofPlot()));
    switches("samples", "samples a pixel", different("samples", ofPlot()).sort((a, b) => a - b));
    draw();
  }

  const select = element("plots");
  plots.forEach((p, i) => make("option", select, { value: String(i) }, p.name));
  select.addEventListener("change", () => { plot = plots[Number(select.value)]; unpin(); update(); });
  svg.addEventListener("click", unpin);
  document.addEventListener("keydown", event => { if (event.key === "Escape") unpin(); });
  for (const button of document.querySelectorAll("button[data-row]")) {
    button.addEventListener("click", () => {
      const point = points[Number(button.dataset.row)];
      const next = plots.findIndex(p => fits(point, p));
      if (next < 0) return;
      if (!fits(point, plot)) { plot = plots[next]; select.value = String(next); }
      on.place.add(point.place), on.variant.add(point.variant), on.samples.add(point.samples);
      update();
      pin(point);
      if (svg.scrollIntoView) svg.scrollIntoView({ block: "nearest" });
    });
  }
  element("interactive").hidden = false;
  update();
})();
)js";

}  // namespace farfield::bench
