/* Zoomable traces of a diagnosis. Each .run element names a run of the data;
   its static figure stays where this script does not run. */
(function () {
  "use strict";
  const source = document.getElementById("runs-data");
  if (!source || typeof uPlot === "undefined") return;
  const runs = JSON.parse(source.textContent);
  document.documentElement.classList.add("has-script");
  const COLOR = { measured: "#1f2933", before: "#d55e00", after: "#0072b2", law: "#00785a" };
  const NAME = { before: "twin before", after: "twin after", law: "with its law" };
  const RULE = { stroke: "#dde2e8", width: 1 };

  function unpack(part) {
    const bytes = Uint8Array.from(atob(part.data), (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    const values = new Array(bytes.length / 2);
    for (let i = 0; i < values.length; i++) {
      const whole = view.getInt16(2 * i, true);
      values[i] = whole === -32768 ? null : part.middle + whole * part.step;
    }
    return values;
  }

  function shown(u, value) {
    return value == null ? "–" : Number(value.toPrecision(4)).toString().replace("-", "−");
  }

  function axis(label, size, space) {
    return { label: label, labelSize: 18, size: size, space: space, font: "12px sans-serif",
      labelFont: "12px sans-serif", stroke: "#46525f", grid: RULE, ticks: RULE };
  }

  function line(label, color, width) {
    return { label: label, stroke: color, width: width, points: { show: false }, value: shown };
  }

  function limits(u) {
    const times = u.data[0];
    return [times[0], times[times.length - 1]];
  }

  function zoom(u, middle, factor, shift) {
    const [first, last] = limits(u);
    const { min, max } = u.scales.x;
    const width = Math.min((max - min) * factor, last - first);
    const from = middle - (middle - min) * (width / (max - min)) + shift * (max - min);
    const low = Math.max(first, Math.min(from, last - width));
    u.setScale("x", { min: low, max: low + width });
  }

  function wheel(u) {
    u.over.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey && !event.shiftKey) return;
      event.preventDefault();
      const turned = event.deltaY || event.deltaX;
      zoom(u, u.posToVal(u.cursor.left, "x"), turned < 0 ? 0.75 : 1 / 0.75, 0);
    }, { passive: false });
  }

  function draw_band(band) {
    return (u) => {
      const top = u.valToPos(band, "y", true), bottom = u.valToPos(-band, "y", true);
      u.ctx.save();
      u.ctx.beginPath();
      u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
      u.ctx.clip();
      u.ctx.fillStyle = "rgba(107, 119, 133, 0.16)";
      u.ctx.fillRect(u.bbox.left, top, u.bbox.width, bottom - top);
      u.ctx.restore();
    };
  }

  /* Both charts of a run keep one time axis. */
  function chart(place, charts, height, series, data, label, hooks, key) {
    const options = {
      width: place.clientWidth, height: height, series: series,
      scales: { x: { time: false } },
      axes: [axis("time, s", 34, 60), axis(label, 58, 18)],
      cursor: { drag: { x: true, y: false }, sync: { key: key } },
      hooks: Object.assign({
        ready: [wheel],
        setScale: [(u, scale) => {
          if (scale !== "x") return;
          const { min, max } = u.scales.x;
          charts.forEach((other) => {
            const x = other.scales.x;
            if (other !== u && (x.min !== min || x.max !== max)) other.setScale("x", { min: min, max: max });
          });
        }],
      }, hooks),
    };
    const made = new uPlot(options, data, place);
    charts.push(made);
  }

  function button(bar, text, title, act) {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = text;
    made.title = title;
    made.setAttribute("aria-label", title);
    made.addEventListener("click", act);
    bar.appendChild(made);
  }

  function build(box) {
    const run = runs[Number(box.dataset.run)];
    const times = unpack(run.time), charts = [];
    const bar = document.createElement("div"), place = document.createElement("div");
    bar.className = "viewer-bar";
    const label = document.createElement("label"), select = document.createElement("select");
    label.append("Channel ", select);
    run.channels.forEach((c, i) => {
      const off = c.gaps[0] === "–" ? "" : ` (${c.gaps[0]} × floor before)`;
      select.add(new Option(c.label + off, i));
    });
    select.value = box.dataset.channel || "0";
    bar.append(label);
    const middle = (u) => 0.5 * (u.scales.x.min + u.scales.x.max);
    const all = (factor, shift) => () => charts.length && zoom(charts[0], middle(charts[0]), factor, shift);
    button(bar, "+", "Zoom in", all(0.5, 0));
    button(bar, "−", "Zoom out", all(2, 0));
    button(bar, "◀", "Earlier", all(1, -0.25));
    button(bar, "▶", "Later", all(1, 0.25));
    button(bar, "Whole run", "Show the whole run", () => {
      const [first, last] = limits(charts[0]);
      charts[0].setScale("x", { min: first, max: last });
    });

    function show() {
      charts.splice(0).forEach((u) => u.destroy());
      const c = run.channels[Number(select.value)];
      const key = "run" + box.dataset.run + (box.dataset.channel ? "hero" : "");
      const time = { label: "time, s", value: shown };
      const twins = c.twins.map((kind) => line(`${NAME[kind]}`, COLOR[kind], 1.3));
      const rest = c.twins.map((kind, i) => line(`${kind === "law" ? "with its law" : kind}, ${c.gaps[i]} × floor`, COLOR[kind], 1));
      chart(place, charts, box.dataset.channel ? 230 : 210,
        [time, line("measured", "#b3bcc6", 4), ...twins],
        [times, ...c.values.map(unpack)], `${c.label}, ${c.unit}`, {}, key);
      chart(place, charts, 180, [time, ...rest],
        [times, ...c.residuals.map(unpack)], `measured − twin, ${c.residualUnit}`,
        { drawAxes: [draw_band(c.band)] }, key);
    }
    select.addEventListener("change", show);
    const live = document.createElement("div");
    live.className = "viewer";
    live.append(bar, place);
    box.prepend(live);
    try {
      show();
    } catch (error) {
      live.remove();
      throw error;
    }
    box.classList.add("is-live");
    new ResizeObserver(() => charts.forEach((u) => {
      if (place.clientWidth) u.setSize({ width: place.clientWidth, height: u.height });
    })).observe(place);
  }

  const boxes = Array.from(document.querySelectorAll(".run[data-run]"));
  const near = new IntersectionObserver((seen) => seen.forEach((entry) => {
    if (!entry.isIntersecting) return;
    near.unobserve(entry.target);
    build(entry.target);
  }), { rootMargin: "600px" });
  boxes.filter((box) => runs[Number(box.dataset.run)].channels.length).forEach((box) => near.observe(box));
})();
