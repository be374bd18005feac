const packed = Uint8Array.from(atob(document.getElementById("data").textContent), c => c.charCodeAt(0));
const data = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
const dialog = document.getElementById("cell");
const W = 900, H = 170, LEFT = 56, BOTTOM = 24, TOP = 8;

/* Least and greatest value of each interval, as one path down and up again. */
function path(values, x, y) {
  const n = values.length / 2, top = [], low = [];
  for (let i = 0; i < n; i++) {
    top.push(`${x(i + .5)},${y(values[2 * i + 1])}`);
    low.push(`${x(i + .5)},${y(values[2 * i])}`);
  }
  return `M${top.join("L")}L${low.reverse().join("L")}Z`;
}

function step(range) {
  const power = 10 ** Math.floor(Math.log10(range / 3));
  return [1, 2, 5, 10].map(k => k * power).find(s => range / s <= 5);
}

function plot(motion, own, other) {
  const all = own.concat(other || []);
  const high = Math.max(motion.least, ...all.map(Math.abs)) * 1.05;
  const x = i => (LEFT + (W - LEFT - 6) * i / data.points).toFixed(1);
  const y = v => (TOP + (H - TOP - BOTTOM) * (high - v) / (2 * high)).toFixed(1);
  let grid = "";
  const s = step(2 * high);
  for (let v = -Math.floor(high / s) * s; v <= high; v += s)
    grid += `<line x1="${LEFT}" x2="${W - 6}" y1="${y(v)}" y2="${y(v)}" stroke="var(--line)"/>` +
      `<text x="${LEFT - 6}" y="${+y(v) + 4}" text-anchor="end">${+(v / 1000).toPrecision(3)}</text>`;
  const d = step(motion.duration * 1.2);
  for (let t = 0; t <= motion.duration; t += d)
    grid += `<text x="${x(data.points * t / motion.duration)}" y="${H - 6}" text-anchor="middle">${+t.toPrecision(3)}</text>`;
  const line = (values, colour) => values
    ? `<path d="${path(values, x, y)}" fill="${colour}" stroke="${colour}" stroke-width=".8" stroke-linejoin="round"/>` : "";
  return `<svg viewBox="0 0 ${W} ${H}" font-size="12" fill="currentColor" role="img">${grid}` +
    `${line(other, "#e07b00")}<g opacity=".85">${line(own, "#3584c4")}</g></svg>`;
}

function show(place) {
  const [drive, name, tuned] = place.split("|");
  const own = data.cells[place] || {};
  const other = data.cells[`${drive}|${data.reference}|${drive}`] || {};
  let inside = `<button class="close" autofocus>Close</button><h3></h3>` +
    `<p class="key">Error over time [s], first run: <b style="color:#3584c4">${name}</b>, ` +
    `<b style="color:#c96e00">${data.reference}</b></p>`;
  for (const [key, motion] of Object.entries(data.motions))
    if (own[key])
      inside += `<h4>${motion.title}. ${motion.unit}</h4>` + plot(motion, own[key], other[key]);
  dialog.innerHTML = inside;
  dialog.querySelector("h3").textContent = `${name} on ${drive}, tuned on ${tuned === drive ? "this drive" : tuned}`;
  dialog.querySelector(".close").onclick = () => dialog.close();
  dialog.showModal();
}

/* Text and colour of a cell of a heat map, as page.py writes them. */
function paint(cell, text, value) {
  const depth = Math.min(Math.abs(Math.log(value)) / Math.log(data.deep), 1) * .85;
  const colour = value < 1 ? [0, 79, 134] : [224, 123, 0];
  const shade = colour.map(c => Math.round(255 + depth * (c - 255)));
  text.textContent = (value < 9.995 ? value.toFixed(2) : value.toPrecision(3)) + (text.textContent.endsWith("*") ? "*" : "");
  cell.style.background = `rgb(${shade})`;
  cell.style.color = depth > .5 && value < 1 ? "#fff" : "#1a1a1a";
}

function choose(command) {
  for (const row of document.querySelectorAll("table.heat tbody tr")) {
    const values = [];
    for (const button of row.querySelectorAll("button")) {
      const value = (data.errors[button.dataset.cell] || {})[command];
      if (value) { paint(button.parentNode, button, value); values.push(value); }
    }
    const figures = {
      mean: Math.exp(values.reduce((sum, v) => sum + Math.log(v), 0) / values.length),
      worst: Math.max(...values),
    };
    for (const cell of row.querySelectorAll("td[data-figure]"))
      paint(cell, cell, figures[cell.dataset.figure]);
  }
  for (const button of document.querySelectorAll("button[data-command]"))
    button.setAttribute("aria-pressed", button.dataset.command === command);
}

for (const button of document.querySelectorAll("button[data-command]"))
  button.onclick = () => choose(button.dataset.command);
for (const button of document.querySelectorAll("button[data-cell]"))
  button.onclick = () => show(button.dataset.cell);
dialog.onclick = event => { if (event.target === dialog) dialog.close(); };
