// The page of the stance detector: a threshold to try. Judges the statistic anew in the browser, at full rate.
(async () => {
  await bematist.ready;
  const { data, color, times } = bematist;
  const live = data.stance, time = bematist.decode(live.time), step = (live.high - live.low) / live.levels;
  const bytes = Uint8Array.from(atob(live.statistic), (c) => c.charCodeAt(0));
  const steps = new Uint16Array(bytes.buffer);
  const byId = (id) => document.getElementById(id);
  const slider = byId("threshold-slider"), entry = byId("threshold"), histogram = byId("plot-histogram");
  const analysed = times.map((own) => own.full.map((full) => full));
  let threshold = live.threshold, tried = false, waiting = false;

  // ---- the verdict ----------------------------------------------------------------------------------------------------

  function edges(limit) { // times at which stances begin and end, in turn
    const level = (Math.log10(limit) - live.low) / step, found = [];
    let standing = false;
    for (let k = 0; k < steps.length; k++) {
      const now = steps[k] !== 65535 && steps[k] < level;
      if (now !== standing) { found.push(time[k]); standing = now; }
    }
    if (standing) found.push(time[time.length - 1]);
    return found;
  }

  function shading(found) {
    const x = new Float64Array(found.length + 2), y = new Float32Array(found.length + 2);
    x.set(found, 1);
    x[0] = time[0];
    x[x.length - 1] = time[time.length - 1];
    found.forEach((_, k) => { y[k + 1] = k % 2 ? 0 : 1; });
    return { x, y };
  }

  const median = (list) => { const s = [...list].sort((a, b) => a - b); return s.length ? s[s.length >> 1] : NaN; };
  const shown = (value, unit, digits) => (Number.isFinite(value) ? value.toFixed(digits) + " " + unit : "–");

  function numbers(found) {
    const lengths = [], cycles = [];
    for (let k = 0; k < found.length; k += 2) {
      lengths.push(found[k + 1] - found[k]);
      if (k) cycles.push(found[k] - found[k - 2]);
    }
    const share = (100 * lengths.reduce((a, b) => a + b, 0)) / (time[time.length - 1] - time[0]);
    document.body.dataset.share = share.toFixed(3);
    document.body.dataset.stances = String(lengths.length);
    const rows = [
      ["Stance", shown(share, "%", 1), "of the time"],
      ["Phases", String(lengths.length), lengths.filter((s) => s < 0.1).length + " shorter than 0.1 s"],
      ["Phase length", shown(median(lengths), "s", 2), "median"],
      ["From phase to phase", shown(median(cycles), "s", 2), "median; a walker's stride takes about 1.1 s"],
    ];
    byId("stance-numbers").replaceChildren(...rows.map((row) => {
      const card = document.createElement("div");
      card.className = "card";
      ["label", "value", "note"].forEach((name, k) => {
        const part = document.createElement("div");
        part.className = name;
        part.textContent = row[k];
        card.append(part);
      });
      return card;
    }));
  }

  // ---- showing it -----------------------------------------------------------------------------------------------------

  const round = (value) => Number(value.toPrecision(3));
  const fraction = (value) => (Math.log10(value) - live.low) / (live.high - live.low);

  function labels() {
    slider.value = String(1000 * fraction(threshold));
    if (document.activeElement !== entry) entry.value = String(round(threshold));
    byId("command").textContent = `--set stance.threshold=${round(threshold)} ${tried ? live.options : ""}`.trim();
  }

  function redraw() {
    waiting = false;
    const found = tried ? edges(threshold) : null;
    const fresh = found && shading(found);
    for (const [n, own] of times.entries()) {
      own.full = own.panel.traces.map((trace, k) => {
        if (!tried) return analysed[n][k];
        if (trace.meta === "shading") return fresh;
        if (trace.meta === "threshold") return { x: Float64Array.from(data.range), y: Float64Array.of(threshold, threshold) };
        return own.full[k];
      });
      bematist.refresh(own);
    }
    numbers(found || analysedEdges());
    Plotly.relayout(histogram, { shapes: [marker()] });
  }

  function analysedEdges() {
    const k = times[0].panel.traces.findIndex((trace) => trace.meta === "shading");
    return [...analysed[0][k].x.slice(1, -1)];
  }

  function choose(value) {
    if (!(value > 0) || !Number.isFinite(value)) return;
    threshold = value;
    tried = true;
    labels();
    if (!waiting) { waiting = true; requestAnimationFrame(redraw); }
  }

  function reset() {
    threshold = live.threshold;
    tried = false;
    entry.blur();
    labels();
    redraw();
  }

  // ---- the histogram --------------------------------------------------------------------------------------------------

  function marker() {
    return { type: "line", x0: threshold, x1: threshold, y0: 0, y1: 1, yref: "paper", line: { color: color("@1"), width: 2, dash: "dash" } };
  }

  function drawHistogram() {
    const trace = {
      type: "scatter", mode: "lines", line: { shape: "hvh", width: 1, color: color("@0") }, fill: "tozeroy", fillcolor: color("@0/0.25"),
      ...live.histogram, hovertemplate: "%{x:.3g}: %{y:.2f} % of the samples<extra></extra>",
    };
    const layout = bematist.layout({
      dragmode: false, hovermode: "x", showlegend: false, shapes: [marker()], 
      xaxis: bematist.axis("statistic", { type: "log", tickformat: "~g", ...(live.high - live.low > 2 ? { dtick: 1 } : {}), fixedrange: true, range: [live.low, live.high] }),
      yaxis: bematist.axis("samples (%)", { fixedrange: true, rangemode: "tozero" }),
    });
    return Plotly.react(histogram, [trace], layout, bematist.config({ displayModeBar: false }));
  }

  await drawHistogram();
  histogram.on("plotly_click", (e) => choose(e.points[0].x));
  slider.addEventListener("input", () => choose(10 ** (live.low + (slider.value / 1000) * (live.high - live.low))));
  entry.addEventListener("input", () => choose(Number(entry.value)));
  byId("threshold-reset").addEventListener("click", reset);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawHistogram);
  labels();
  numbers(analysedEdges());
  bematist.choose = choose;
  document.body.dataset.ready = String(document.querySelectorAll(".js-plotly-plot").length);
})();
