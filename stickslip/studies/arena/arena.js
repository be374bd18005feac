const packed = Uint8Array.from(atob(document.getElementById("data").textContent), c => c.charCodeAt(0));
const data = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).json();

/* Least and greatest value of each interval, as a line down and up again. */
function line(label, colour, values, duration) {
  const n = values.length / 2, x = values.map((_, i) => duration * (Math.floor(i / 2) + i % 2 / 2) / n);
  return { label, colour, joined: true, x, y: values.map(value => value / 1000) };
}

/* The command that makes the motions of a cell again. */
function again(drive, name, tuned) {
  const drives = [...new Set([tuned, drive])].join(" "), names = [...new Set([data.reference, name])].join(" ");
  return `stickslip arena --only ${drives} --compensators ${names} ${data.settings} --out motions`;
}

function show(place) {
  const [drive, name, tuned] = place.split("|");
  const own = data.cells[place] || {};
  const other = place === `${drive}|${data.reference}|${drive}` ? {} : data.cells[`${drive}|${data.reference}|${drive}`] || {};
  const panels = Object.entries(data.motions).filter(([key]) => own[key]).map(([key, motion]) => {
    const lines = [line(name, "#004f86", own[key], motion.duration)];
    if (other[key]) lines.unshift(line(data.reference, "#e07b00", other[key], motion.duration));
    const high = 1.05 * Math.max(motion.least / 1000, ...lines.flatMap(one => one.y.map(Math.abs)));
    return {
      title: motion.title, link: key, lines,
      x: { label: "Time [s]", scale: "linear", range: [0, motion.duration] },
      y: { label: motion.unit, scale: "linear", range: [-high, high] },
    };
  });
  const title = `${name} on ${drive}, tuned on ${tuned === drive ? "this drive" : tuned}`;
  if (panels.length) openPanels(panels, `${title}, first run`);
  else openPanels([], `${title}: ${again(drive, name, tuned)}`);
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
