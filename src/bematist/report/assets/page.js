"use strict";
// Draws the figures of the page from #page-data, keeps their time axes together, and shows where on the path a moment was.
// Colours come as tokens ("@0", "@ink/0.3") and are looked up in the style sheet, so that the theme of the reader counts.
const bematist = (() => {
  const data = JSON.parse(document.getElementById("page-data").textContent);
  const DOTS = 300; // the same for dots, each of which costs a node of the document
  const DRAWN = 1000; // pairs of extremes that one trace draws at most; more cannot be seen, fewer are fluent
  const coarse = matchMedia("(pointer: coarse)").matches;
  const narrow = () => window.innerWidth < 560;
  const times = [];   // {div, panel, full: [{x, y}], own}
  let plan = null, view = null, pending = 0;

  // ---- data and colours -----------------------------------------------------------------------------------------------

  function decode(value) {
    if (!value || !value.bdata) return value;
    const bytes = Uint8Array.from(atob(value.bdata), (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer), wide = value.dtype === "f8", size = wide ? 8 : 4;
    const out = wide ? new Float64Array(bytes.length / 8) : new Float32Array(bytes.length / 4);
    for (let k = 0; k < out.length; k++) out[k] = wide ? view.getFloat64(k * size, true) : view.getFloat32(k * size, true);
    return out;
  }

  function color(token) {
    const [, name, alpha] = token.match(/^@(\w+)(?:\/([\d.]+))?$/) || [];
    if (!name) return token;
    const key = /^\d/.test(name) ? "--c" + name : "--" + name;
    const hex = getComputedStyle(document.documentElement).getPropertyValue(key).trim();
    if (!alpha) return hex;
    const n = parseInt(hex.slice(1), 16);
    return `rgba(${n >> 16},${(n >> 8) & 255},${n & 255},${alpha})`;
  }

  // A trace as plotly takes it: tokens become colours; typed arrays are passed on as they are.
  function themed(value) {
    if (typeof value === "string") return value.startsWith("@") ? color(value) : value;
    if (Array.isArray(value)) return value.map(themed);
    if (value && typeof value === "object" && !ArrayBuffer.isView(value)) {
      return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, themed(v)]));
    }
    return value;
  }

  // ---- drawing less ---------------------------------------------------------------------------------------------------

  function lower(x, t) { // first index with x >= t
    let a = 0, b = x.length;
    while (a < b) { const m = (a + b) >> 1; if (x[m] < t) a = m + 1; else b = m; }
    return a;
  }

  // The part of a trace inside [from, to] and one point on either side; of many, the extremes of each bucket.
  function visible(full, from, to, most = DRAWN) {
    const a = Math.max(0, lower(full.x, from) - 1), b = Math.min(full.x.length, lower(full.x, to) + 1);
    if (b - a <= 2 * most) return { x: full.x.slice(a, b), y: full.y.slice(a, b) };
    const keep = [a], size = (b - a) / most;
    for (let k = 0; k < most; k++) {
      const start = a + Math.floor(k * size), end = a + Math.floor((k + 1) * size);
      let low = -1, high = -1;
      for (let i = start; i < end; i++) {
        const v = full.y[i];
        if (v !== v) continue;
        if (low < 0 || v < full.y[low]) low = i;
        if (high < 0 || v > full.y[high]) high = i;
      }
      if (low < 0) keep.push(start);
      else if (low === high) keep.push(low);
      else keep.push(Math.min(low, high), Math.max(low, high));
    }
    keep.push(b - 1);
    const kind = full.x.constructor;
    return { x: kind.from(keep, (i) => full.x[i]), y: Float32Array.from(keep, (i) => full.y[i]) };
  }

  // Dots are strokes without length that the style sheet gives round ends: one path instead of thousands of nodes.
  function dots({ x, y }) {
    const wide = new x.constructor(3 * x.length), high = new Float32Array(3 * x.length).fill(NaN);
    for (let k = 0; k < x.length; k++) {
      wide.fill(x[k], 3 * k, 3 * k + 3);
      high.fill(y[k], 3 * k, 3 * k + 2);
    }
    return { x: wide, y: high };
  }

  const thrice = (list) => list.constructor.from({ length: 3 * list.length }, (_, k) => list[Math.floor(k / 3)]);

  const drawn = (own, k) => {
    const few = own.panel.traces[k].meta === "dots";
    const part = visible(own.full[k], ...view, few ? DOTS : DRAWN);
    return few ? dots(part) : part;
  };

  // ---- figures --------------------------------------------------------------------------------------------------------

  function axis(title, more) {
    return {
      title: { text: title, font: { size: 12.5 }, standoff: 6 }, gridcolor: color("@grid"), linecolor: color("@edge"),
      zerolinecolor: color("@edge"), zerolinewidth: 1, tickfont: { size: 11.5 }, automargin: true, ...more,
    };
  }

  function layout(more) {
    return {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", margin: { l: narrow() ? 58 : 68, r: 14, t: 10, b: 38 },
      font: { family: getComputedStyle(document.body).fontFamily, color: color("@ink"), size: 12.5 },
      legend: { orientation: "h", traceorder: "normal", x: 0, y: 1, xanchor: "left", yanchor: "bottom", font: { size: 12 }, bgcolor: "rgba(0,0,0,0)" },
      hoverlabel: { bgcolor: color("@surface"), bordercolor: color("@edge"), font: { color: color("@ink"), size: 12.5 } },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: color("@muted"), activecolor: color("@ink") },
      ...more,
    };
  }

  // plotly.js would offer to send the data of the plot to its maker's server.
  const config = (more) => ({
    responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "", doubleClick: "reset", modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], ...more,
  });

  function timeLayout(panel) {
    const [from, to] = view;
    const { yaxis, ...rest } = themed(panel.layout || {});
    const log = panel.log ? { type: "log", tickformat: "~g" } : {};
    // No automargin for y: the time axes of all plots must stand below one another.
    return layout({
      dragmode: coarse ? false : "zoom", hovermode: "x unified", hoverdistance: 40,
      xaxis: axis("time (s)", { range: [from, to], hoverformat: ".2f", unifiedhovertitle: { text: "%{x:.2f} s" }, zeroline: false, showspikes: false }),
      yaxis: axis(panel.axis, { ...log, nticks: 6, zeroline: !panel.log, automargin: false, ...yaxis }),
      yaxis2: { overlaying: "y", range: [0, 1], visible: false, fixedrange: true },
      showlegend: panel.traces.some((t) => t.showlegend) && panel.traces.filter((t) => t.showlegend).length > 1,
      ...rest,
    });
  }

  function traces(own) {
    return own.panel.traces.map((trace, k) => ({ ...own.themed[k], ...drawn(own, k) }));
  }

  async function drawTime(panel) {
    const div = document.getElementById("plot-" + panel.key);
    const names = panel.traces.filter((t) => t.showlegend).length;
    if (narrow() && names > 2) div.style.height = 200 + 20 * names + "px"; // its legend may need a row for each
    const full = panel.traces.map((t) => ({ x: decode(t.x), y: decode(t.y) }));
    const own = { div, panel, full, themed: panel.traces.map((t) => themed({ ...t, x: null, y: null })) };
    times.push(own);
    await Plotly.newPlot(div, traces(own), timeLayout(panel), config());
    own.cursor = overlay(div, "instant");
    own.shown = [...view];
    div.on("plotly_relayout", (change) => follow(own, change));
    div.on("plotly_hover", (e) => e.xvals && point(e.xvals[0]));
    div.on("plotly_unhover", () => point(null));
  }

  function planLayout() {
    const [x, y] = data.view || [];
    return layout({
      dragmode: coarse ? false : "pan", hovermode: "closest", showlegend: true, images: data.image ? [data.image] : [],
      xaxis: axis("east (m)", { zeroline: false, ...(x && { range: [...x] }) }),
      yaxis: axis("north (m)", { zeroline: false, scaleanchor: "x", scaleratio: 1, ...(y && { range: [...y] }) }),
    });
  }

  async function drawPlan() {
    const div = document.getElementById("plot-plan");
    if (!div) return;
    const all = data.plan.map((t) => {
      const whole = { ...t, x: decode(t.x), y: decode(t.y), customdata: decode(t.customdata) };
      return t.meta === "dots" ? { ...whole, ...dots(whole), customdata: thrice(whole.customdata) } : whole;
    });
    const paths = all.filter((t) => t.meta === "path");
    // A second, bolder line over each path shows the part of it that the time plots show.
    const parts = paths.map((t) => ({
      type: "scatter", mode: "lines", x: [], y: [], hoverinfo: "skip", showlegend: false, line: { color: t.line.color, width: 3 },
    }));
    plan = { div, all: [...all, ...parts], paths, part: all.length, whole: all.map((t, k) => (t.meta ? k : -1)).filter((k) => k >= 0) };
    await Plotly.newPlot(div, themed(plan.all), planLayout(), config({ scrollZoom: !coarse }));
    plan.cursors = paths.map(() => overlay(div, "place"));
    div.on("plotly_hover", (e) => { const t = e.points[0].customdata; if (t !== undefined) point(t); });
    div.on("plotly_unhover", () => point(null));
  }

  // ---- one view of time -----------------------------------------------------------------------------------------------

  // A plot was zoomed by hand: the others follow. Plotly.update, with which they do, reports no relayout, so nothing runs in circles.
  function follow(own, change) {
    const whole = change["xaxis.autorange"];
    const from = change["xaxis.range[0]"] ?? change["xaxis.range"]?.[0], to = change["xaxis.range[1]"] ?? change["xaxis.range"]?.[1];
    if (!whole && (from === undefined || to === undefined)) return;
    show(whole ? data.range : [Number(from), Number(to)], own);
  }

  function show(range, first) {
    if (!(range[1] > range[0])) return;
    view = [...range];
    const turn = ++pending;
    const near = (own) => { const r = own.div.getBoundingClientRect(); return r.bottom > 0 && r.top < innerHeight ? 0 : 1; };
    const queue = times.filter((own) => own !== first).sort((a, b) => near(a) - near(b));
    if (first) queue.unshift(first);
    const jobs = queue.map((own) => () => refresh(own));
    jobs.splice(1, 0, part);
    const next = async () => { // what can be seen comes first; a newer zoom ends an older one
      while (jobs.length && turn === pending) {
        await jobs.shift()();
        await new Promise((done) => setTimeout(done, 0));
      }
      if (turn === pending) document.body.dataset.view = view.join(" ");
    };
    return next();
  }

  function refresh(own) {
    const shown = own.full.map((_, k) => drawn(own, k));
    own.shown = [...view];
    return Plotly.update(own.div, { x: shown.map((s) => s.x), y: shown.map((s) => s.y) }, { "xaxis.range": [...view], "xaxis.autorange": false });
  }

  function part() {
    if (!plan || !plan.paths.length) return;
    const all = view[0] <= data.range[0] && view[1] >= data.range[1];
    const cut = plan.paths.map((p) => {
      if (all) return { x: [], y: [] };
      const a = lower(p.customdata, view[0]), b = lower(p.customdata, view[1]);
      const ends = [place(p, view[0]), place(p, view[1])];
      return { x: [ends[0][0], ...p.x.slice(a, b), ends[1][0]], y: [ends[0][1], ...p.y.slice(a, b), ends[1][1]] };
    });
    const whole = plan.whole.map((k) => plan.all[k]);
    const change = {
      x: [...cut, ...whole].map((c) => c.x), y: [...cut, ...whole].map((c) => c.y),
      opacity: [...cut.map(() => 1), ...whole.map(() => (all ? 1 : 0.35))],
    };
    return Plotly.restyle(plan.div, change, [...cut.map((_, k) => plan.part + k), ...plan.whole]);
  }

  // ---- one moment -----------------------------------------------------------------------------------------------------

  function overlay(div, kind) {
    const mark = document.createElement("div");
    mark.className = "cursor " + kind;
    div.appendChild(mark);
    return mark;
  }

  function place(path, t) {
    const x = path.customdata, k = Math.min(Math.max(lower(x, t), 1), x.length - 1);
    if (x.length < 2) return [path.x[0], path.y[0]];
    const w = Math.min(1, Math.max(0, (t - x[k - 1]) / (x[k] - x[k - 1])));
    return [path.x[k - 1] + w * (path.x[k] - path.x[k - 1]), path.y[k - 1] + w * (path.y[k] - path.y[k - 1])];
  }

  function point(t) {
    for (const own of times) {
      const a = own.div._fullLayout?.xaxis, y = own.div._fullLayout?.yaxis;
      if (!own.cursor || !a) continue;
      const inside = t !== null && t >= own.shown[0] && t <= own.shown[1];
      own.cursor.style.display = inside ? "block" : "none";
      if (inside) Object.assign(own.cursor.style, { left: a._offset + a.l2p(t) + "px", top: y._offset + "px", height: y._length + "px" });
    }
    plan?.cursors.forEach((mark, k) => {
      const { xaxis: ax, yaxis: ay } = plan.div._fullLayout;
      const [x, y] = t === null ? [NaN, NaN] : place(plan.paths[k], t);
      const px = ax.l2p(x), py = ay.l2p(y);
      const inside = px >= 0 && px <= ax._length && py >= 0 && py <= ay._length;
      mark.style.display = inside ? "block" : "none";
      if (inside) Object.assign(mark.style, { left: ax._offset + px + "px", top: ay._offset + py + "px", borderColor: color(plan.paths[k].line.color) });
    });
  }

  // ---- start ----------------------------------------------------------------------------------------------------------

  async function retheme() {
    for (const own of times) {
      own.themed = own.panel.traces.map((t) => themed({ ...t, x: null, y: null }));
      await Plotly.react(own.div, traces(own), timeLayout(own.panel), config());
    }
    if (plan) {
      await Plotly.react(plan.div, themed(plan.all), planLayout(), config({ scrollZoom: !coarse }));
      part();
    }
  }

  async function start() {
    view = [...data.range];
    if (!(view[1] > view[0])) view[1] = view[0] + 1;
    await drawPlan();
    for (const panel of data.panels) {
      await drawTime(panel);
      await new Promise((done) => setTimeout(done, 0)); // the page answers while it draws
    }
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", retheme);
    document.body.dataset.ready = String(document.querySelectorAll(".js-plotly-plot").length);
  }

  const ready = start();
  return { data, times, ready, show, point, color, layout, axis, config, decode, themed, refresh, retheme };
})();
