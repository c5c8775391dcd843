// The page of a calibration: spheres to turn, and flat plots whose horizontal axis is not time.
(async () => {
  await bematist.ready;
  const { data, themed, decode } = bematist;
  const read = (trace) => themed({ ...trace, x: decode(trace.x), y: decode(trace.y), ...(trace.z ? { z: decode(trace.z) } : {}) });

  function ball() {
    const side = (title) => ({ title, range: [-1.35, 1.35], color: bematist.color("@ink"), gridcolor: bematist.color("@ink/0.12"), showbackground: false });
    return bematist.layout({
      dragmode: "orbit", hovermode: false, margin: { l: 0, r: 0, t: 0, b: 0 }, legend: { orientation: "h", y: 1 },
      scene: { aspectmode: "cube", xaxis: side("x"), yaxis: side("y"), zaxis: side("z") },
    });
  }

  function flat(plot) {
    return bematist.layout({
      hovermode: "closest", legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" }, xaxis: bematist.axis(plot.x, {}), yaxis: bematist.axis(plot.y, {}),
    });
  }

  async function draw() {
    for (const plot of data.calibration) {
      const div = document.getElementById("plot-" + plot.key);
      await Plotly.react(div, plot.traces.map(read), plot.kind === "ball" ? ball() : flat(plot), bematist.config({ scrollZoom: false }));
    }
    document.body.dataset.ready = String(document.querySelectorAll(".js-plotly-plot").length);
  }

  await draw();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
})();
