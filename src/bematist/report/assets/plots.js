// Pages whose plots have no time in common: spheres to turn, flat plots, and plots of logarithms.
(async () => {
  await bematist.ready;
  const { data, themed, decode } = bematist;
  const read = (trace) => themed({ ...trace, x: decode(trace.x), y: decode(trace.y), ...(trace.z ? { z: decode(trace.z) } : {}) });

  function ball() {
    const side = (title) => ({ title, range: [-1.35, 1.35], color: bematist.color("@ink"), gridcolor: bematist.color("@ink/0.12"), showbackground: false });
    return bematist.layout({
      dragmode: "orbit", hovermode: false, margin: { l: 0, r: 0, t: 0, b: 0 }, legend: { orientation: "h", y: 1 },
      scene: { aspectmode: "cube", camera: { eye: { x: 1.55, y: 1.55, z: 1.05 } }, xaxis: side("x"), yaxis: side("y"), zaxis: side("z") },
    });
  }

  function flat(plot) {
    const side = (title, range) => bematist.axis(title, plot.kind === "log" ? { type: "log", exponentformat: "power", dtick: range[1] - range[0] > 1.7 ? 1 : "D2", minor: { showgrid: true, gridcolor: bematist.color("@grid/0.5") }, zeroline: false, range: [...range] } : {});
    return bematist.layout({
      hovermode: "closest", legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" }, xaxis: side(plot.x, plot.range_x || []), yaxis: side(plot.y, plot.range_y || []),
    });
  }

  async function draw() {
    for (const plot of data.plots) {
      const div = document.getElementById("plot-" + plot.key);
      await Plotly.react(div, plot.traces.map(read), plot.kind === "ball" ? ball() : flat(plot), bematist.config({ scrollZoom: false }));
    }
    document.body.dataset.ready = String(document.querySelectorAll(".js-plotly-plot").length);
  }

  await draw();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
})();
