// Small things that a page of numbers needs: sorting, slices with sliders, copying. No library, no network.
(() => {
  "use strict";
  const each = (selector, f, root = document) => root.querySelectorAll(selector).forEach(f);

  // Tables: the button of a column sorts by it, and again the other way. Cells may carry their number.
  const valueOf = (row, i) => {
    const cell = row.cells[i];
    const given = cell.dataset.v;
    if (given === undefined) return cell.textContent.trim();
    return given === "" ? null : Number(given);
  };
  const sort = (table, i, sign) => {
    const body = table.tBodies[0];
    const rows = [...body.rows].map((row) => [valueOf(row, i), row]);
    rows.sort(([a], [b]) => {
      if (a === null || b === null) return (a === null) - (b === null); // unknown last, either way
      return sign * (typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(b, "en", { numeric: true }));
    });
    body.append(...rows.map(([, row]) => row));
  };
  each("table.sortable", (table) => {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, i) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const up = head.getAttribute("aria-sort") !== "ascending";
        heads.forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
        sort(table, i, up ? 1 : -1);
      });
    });
  });

  // Code: one language is shown; a choice holds for all blocks of the page.
  const show = (language) =>
    each(".code", (block) => {
      const pres = [...block.querySelectorAll("pre[data-language]")];
      const chosen = pres.find((pre) => pre.dataset.language === language) || pres[0];
      pres.forEach((pre) => (pre.hidden = pre !== chosen));
      block.querySelector("select").value = chosen.dataset.language;
    });
  each(".code select", (select) => select.addEventListener("change", () => show(select.value)));
  if (document.querySelector(".code")) show("glsl");

  // Copying: the clipboard, or where a browser has none for local files, a selection.
  const copied = async (text) => {
    try {
      await navigator.clipboard.writeText(text);
      return true;
    } catch {
      const area = document.createElement("textarea");
      area.value = text;
      document.body.append(area);
      area.select();
      const done = document.execCommand("copy");
      area.remove();
      return done;
    }
  };
  each("button.copy", (button) => {
    const label = button.textContent;
    button.addEventListener("click", async () => {
      const pre = button.closest(".copyable").querySelector("pre:not([hidden])");
      button.textContent = (await copied(pre.textContent)) ? "Copied" : "Select and copy by hand";
      button.focus();
      setTimeout(() => (button.textContent = label), 2000);
    });
  });

  // Slices: curves of the truth with the approximation on them, and below the signed error.
  const unpack = (text, low, high) => {
    const bytes = atob(text);
    const out = new Float64Array(bytes.length / 2);
    for (let i = 0; i < out.length; i++) {
      const n = bytes.charCodeAt(2 * i) + 256 * bytes.charCodeAt(2 * i + 1);
      out[i] = n === 65535 ? NaN : low + ((high - low) * n) / 65534;
    }
    return out;
  };
  const NS = "http://www.w3.org/2000/svg";
  const draw = (parent, name, attributes, text) => {
    const node = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text !== undefined) node.textContent = text;
    parent.append(node);
    return node;
  };
  const short = (x) => {
    if (x === 0) return "0";
    const size = Math.abs(x);
    return size >= 1e-3 && size < 1e4 ? String(Number(x.toPrecision(4))) : x.toExponential(1);
  };
  const ticks = (low, high) => {
    const raw = (high - low) / 4;
    const unit = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 2.5, 5, 10].map((k) => k * unit).find((k) => k >= raw * 0.99);
    const out = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push(k * step);
    return out;
  };
  const panel = (svg, box, xs, ys, yLabel, xLabel) => {
    const x = (v) => box.left + ((v - xs[0]) / (xs[1] - xs[0] || 1)) * box.width;
    const y = (v) => box.top + (1 - (v - ys[0]) / (ys[1] - ys[0] || 1)) * box.height;
    const grid = { stroke: "currentColor", "stroke-opacity": 0.15 };
    for (const t of ticks(...ys)) {
      draw(svg, "line", { x1: box.left, x2: box.left + box.width, y1: y(t), y2: y(t), ...grid });
      draw(svg, "text", { x: box.left - 7, y: y(t) + 4, "text-anchor": "end" }, short(t));
    }
    for (const t of ticks(...xs)) {
      draw(svg, "line", { x1: x(t), x2: x(t), y1: box.top, y2: box.top + box.height, ...grid });
      if (xLabel) draw(svg, "text", { x: x(t), y: box.top + box.height + 17, "text-anchor": "middle" }, short(t));
    }
    if (xLabel) draw(svg, "text", { x: box.left + box.width / 2, y: box.top + box.height + 36, "text-anchor": "middle" }, xLabel);
    draw(svg, "text", { transform: `translate(14 ${box.top + box.height / 2}) rotate(-90)`, "text-anchor": "middle" }, yLabel);
    return { x, y };
  };
  const path = (points) => {
    let out = "";
    let pen = false;
    for (const [px, py] of points) {
      if (Number.isFinite(py)) out += `${pen ? "L" : "M"}${px.toFixed(1)} ${py.toFixed(1)}`;
      pen = Number.isFinite(py);
    }
    return out;
  };
  const slices = (root) => {
    const data = JSON.parse(root.querySelector("script").textContent);
    const truth = unpack(data.truth, data.low, data.high);
    const series = data.series.map((s) => ({ ...s, error: unpack(s.error, -s.bound, s.bound) }));
    const axes = data.axes;
    const sliders = [...root.querySelectorAll('input[type="range"]')];
    const choice = root.querySelector("select");
    const last = axes[axes.length - 1];
    const family = axes.length > 1 ? axes[axes.length - 2] : null;
    const curves = family ? family.at.length : 1;
    const points = last.at.length;
    const plot = root.querySelector(".plot");
    const update = () => {
      const at = sliders.map((slider) => Number(slider.value));
      let start = 0;
      sliders.forEach((slider, i) => {
        start = start * axes[i].at.length + at[i];
        const text = `${axes[i].name} = ${short(axes[i].at[at[i]])}`;
        slider.closest("label").querySelector("output").textContent = text;
        slider.setAttribute("aria-valuetext", text);
      });
      start *= curves * points;
      const s = series[Number(choice.value)];
      plot.replaceChildren();
      const where = sliders.map((slider) => slider.getAttribute("aria-valuetext")).join(", ");
      const svg = draw(plot, "svg", { viewBox: `0 0 960 ${s ? 520 : 340}`, role: "img", "font-size": 13, fill: "currentColor",
        "aria-label": `${data.quantity} along ${last.name}${where ? " at " + where : ""}${s ? ", and the error of " + s.name : ""}` });
      const xs = [last.at[0], last.at[points - 1]];
      const margin = 0.03 * (data.high - data.low);
      const top = panel(svg, { left: 78, top: 14, width: 740, height: 270 }, xs, [data.low - margin, data.high + margin], data.quantity, s ? "" : last.name);
      const below = s && panel(svg, { left: 78, top: 312, width: 740, height: 150 }, xs, [-s.bound * 1.05, s.bound * 1.05], "fit − truth", last.name);
      for (let c = 0; c < curves; c++) {
        const index = (k) => start + c * points + k;
        const colour = curves > 1 ? data.shades[c % data.shades.length] : "currentColor";
        const line = (p, f) => path(last.at.map((v, k) => [p.x(v), p.y(f(k))]));
        draw(svg, "path", { class: "truth", d: line(top, (k) => truth[index(k)]), fill: "none", stroke: colour, "stroke-width": 2 });
        if (s) {
          last.at.forEach((v, k) => {
            const value = truth[index(k)] + s.error[index(k)];
            if (k % 2 === 0 && Number.isFinite(value)) draw(svg, "circle", { cx: top.x(v).toFixed(1), cy: top.y(value).toFixed(1), r: 3, fill: "none", stroke: colour, "stroke-width": 1.3 });
          });
          draw(svg, "path", { class: "error", d: line(below, (k) => s.error[index(k)]), fill: "none", stroke: colour, "stroke-width": 2 });
        }
        if (family) {
          const y = 26 + 20 * c;
          draw(svg, "line", { x1: 832, x2: 856, y1: y - 4, y2: y - 4, stroke: colour, "stroke-width": 3 });
          draw(svg, "text", { x: 862, y }, `${family.name} = ${short(family.at[c])}`);
        }
      }
      const said = [...(s ? ["line: truth", "rings: fit"] : []), ...sliders.map((slider) => slider.getAttribute("aria-valuetext"))];
      said.forEach((text, i) => draw(svg, "text", { x: 832, y: 34 + 20 * curves + 18 * i }, text));
    };
    for (const control of [...sliders, choice]) {
      for (const event of ["input", "change"]) control.addEventListener(event, update);
    }
    root.hidden = false;
    update();
  };
  each(".slices", slices);
})();
