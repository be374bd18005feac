const text = async id => {
  const packed = Uint8Array.from(atob(document.getElementById(id).textContent), c => c.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
};
const figures = JSON.parse(await text("plots"));
const dialog = document.body.appendChild(document.createElement("dialog"));
dialog.className = "plot";
dialog.onclick = event => { if (event.target === dialog) dialog.close(); };

function drawn(panel, range) {
  const { figure } = Bokeh.Plotting;
  const plot = figure({
    title: panel.title, x_axis_label: panel.x.label, y_axis_label: panel.y.label,
    x_axis_type: panel.x.scale, y_axis_type: panel.y.scale,
    x_range: range || panel.x.range, y_range: panel.y.range,
    height: 300, sizing_mode: "stretch_width", tools: "pan,box_zoom,xwheel_zoom,reset,save",
    active_drag: "box_zoom",
  });
  for (const line of panel.lines) {
    const source = new Bokeh.ColumnDataSource({ data: { x: line.x, y: line.y } });
    const look = { source, color: line.colour, ...(line.label && { legend_label: line.label }) };
    const glyph = line.joined
      ? plot.line({ field: "x" }, { field: "y" }, { ...look, line_width: 1.5, line_dash: line.dashed ? "dashed" : "solid" })
      : plot.scatter({ field: "x" }, { field: "y" }, { ...look, size: line.x.length > 200 ? 3 : 6 });
    plot.add_tools(new Bokeh.HoverTool({
      renderers: [glyph], mode: "mouse", visible: false,
      tooltips: [[line.label || panel.y.label || "y", "@y{0.[00000]a}"], [panel.x.label || "x", "@x{0.[00000]a}"]],
    }));
  }
  plot.legend.click_policy = "hide";
  plot.toolbar.logo = null;
  return plot;
}

async function open(name) {
  if (!window.Bokeh) {
    const script = document.createElement("script");
    script.textContent = await text("bokeh");
    document.head.append(script);
  }
  dialog.innerHTML = `<button class="close" autofocus>Close</button><div></div>`;
  dialog.querySelector(".close").onclick = () => dialog.close();
  dialog.showModal();
  const ranges = {};
  const plots = figures[name].map(panel => {
    const plot = drawn(panel, ranges[panel.link]);
    ranges[panel.link] ||= plot.x_range;
    return plot;
  });
  Bokeh.Plotting.show(new Bokeh.Column({ children: plots, sizing_mode: "stretch_width" }), dialog.querySelector("div"));
}

for (const figure of document.querySelectorAll("figure[data-plot]")) {
  const button = document.createElement("button");
  button.className = "open";
  button.textContent = "Zoom and read values";
  button.onclick = () => open(figure.dataset.plot);
  figure.querySelector("figcaption").before(button);
}
