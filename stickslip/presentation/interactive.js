const text = async id => {
  const packed = Uint8Array.from(atob(document.getElementById(id).textContent), c => c.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
};
const figures = JSON.parse(await text("plots"));
const dialog = document.body.appendChild(document.createElement("dialog"));
dialog.className = "plot";
dialog.onclick = event => { if (event.target === dialog) dialog.close(); };

function drawn(panel, range) {
  const plot = Bokeh.Plotting.figure({
    title: panel.title, x_axis_label: panel.x.label, y_axis_label: panel.y.label,
    x_axis_type: panel.x.scale, y_axis_type: panel.y.scale,
    x_range: range || panel.x.range, y_range: panel.y.range,
    height: 300, sizing_mode: "stretch_width", tools: "pan,box_zoom,xwheel_zoom,reset,save",
    active_drag: "box_zoom",
  });
  for (const [axis, words] of [[plot.xaxis, panel.x.words], [plot.yaxis, panel.y.words]]) {
    const ticks = Object.keys(words || {});
    if (!ticks.length) continue;
    axis.ticker = new Bokeh.FixedTicker({ ticks: ticks.map(Number) });
    axis.major_label_overrides = new Map(ticks.map(tick => [Number(tick), words[tick]]));
  }
  const items = [];
  for (const line of panel.lines) {
    const names = line.names?.length ? line.names : line.x.map(() => line.label);
    const [x, y] = [line.x, line.y].map(values => values.map(one => one ?? NaN));
    const source = new Bokeh.ColumnDataSource({ data: { x, y, names } });
    const look = { source, color: line.colour }, glyphs = [];
    if (line.joined)
      glyphs.push(plot.line({ field: "x" }, { field: "y" }, { ...look, line_width: 1.5, line_dash: line.dashed ? "dashed" : "solid" }));
    const bar = line.mark === "|" && { marker: "dash", angle: Math.PI / 2, size: 18, line_width: 2 };
    if (line.mark || !line.joined)
      glyphs.push(plot.scatter({ field: "x" }, { field: "y" }, { ...look, size: x.length > 200 ? 3 : 7, ...bar }));
    const worded = [panel.x, panel.y].some(axis => Object.keys(axis.words || {}).length);
    if (line.names?.length && !worded)
      plot.text({ field: "x" }, { field: "y" }, { field: "names" }, { source, text_font_size: "11px", x_offset: 7, y_offset: 4 });
    if (line.label)
      items.push(new Bokeh.LegendItem({ label: { value: line.label }, renderers: glyphs }));
    const told = line.names?.length || line.label ? [["", "@names"]] : [];
    const rows = ["x", "y"].filter(axis => !Object.keys(panel[axis].words || {}).length)
      .map(axis => [panel[axis].label || panel.title || axis, `@${axis}{0.[00000]a}`]);
    plot.add_tools(new Bokeh.HoverTool({
      renderers: glyphs, mode: "mouse", visible: false, tooltips: [...told, ...rows],
    }));
  }
  if (items.length > 1)
    plot.add_layout(new Bokeh.Legend({
      items, click_policy: "hide", orientation: "horizontal", border_line_width: 0, location: "left", margin: 0, padding: 0,
      ncols: Math.min(items.length, innerWidth < 700 ? 1 : 4),
    }), "below");
  plot.toolbar.logo = null;
  return plot;
}

/* Show panels in a dialog; those of one link share their abscissa. */
async function open(panels, title = "") {
  if (!window.Bokeh) {
    const script = document.createElement("script");
    script.textContent = await text("bokeh");
    document.head.append(script);
  }
  dialog.innerHTML = `<button class="close" autofocus>Close</button><h3></h3><div></div>`;
  dialog.querySelector("h3").textContent = title;
  dialog.querySelector(".close").onclick = () => dialog.close();
  dialog.showModal();
  const ranges = {};
  const plots = panels.map(panel => {
    const plot = drawn(panel, ranges[panel.link]);
    ranges[panel.link] ||= plot.x_range;
    return plot;
  });
  Bokeh.Plotting.show(new Bokeh.Column({ children: plots, sizing_mode: "stretch_width" }), dialog.querySelector("div"));
}
window.openPanels = open;

for (const figure of document.querySelectorAll("figure[data-plot]")) {
  const button = document.createElement("button");
  button.className = "open";
  button.textContent = "Zoom and read values";
  button.onclick = () => open(figures[figure.dataset.plot]);
  figure.querySelector("figcaption").before(button);
}
