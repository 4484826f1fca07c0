"use strict";
// The charts: what is drawn of the columns that page.js keeps.

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const colour = (i) => css(`--c${i % 8}`);
const shown = (value, digits) => (value == null ? "–" : value.toFixed(digits).replace("-", "−"));
/** Digits that tell three significant places of a number of this size. */
const digits = (size) => Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(Math.abs(size) || 1))));
const clock = (s) => {
  const whole = Math.floor(Math.abs(s));
  const pad = (n) => String(n).padStart(2, "0");
  const minutes = `${Math.floor(whole / 60) % 60}:${pad(whole % 60)}`;
  return (s < 0 ? "−" : "") + (whole < 3600 ? minutes : `${Math.floor(whole / 3600)}:${minutes.padStart(5, "0")}`);
};

/** Room above and below, and never less than `least` from bottom to top. */
const range = (least) => (_, low, high) => {
  if (low == null) return [0, least];
  const span = Math.max(high - low, least), middle = (low + high) / 2;
  return [middle - 0.55 * span, middle + 0.55 * span];
};
const fromZero = (least) => (_, __, high) => [0, 1.08 * Math.max(high ?? 0, least)];

const axis = (more) => ({
  stroke: css("--quiet"), font: "11px system-ui, sans-serif", gap: 4,
  grid: { stroke: css("--grid"), width: 1 }, ticks: { show: false }, ...more,
});

/** One chart with its heading, its legend and its name for a screen reader. */
class Panel {
  constructor(place, { name, unit, id }) {
    this.figure = document.createElement("figure");
    this.figure.className = "chart";
    this.figure.id = id;
    const title = document.createElement("h2");
    title.id = `${id}-title`;
    title.textContent = `${name} `;
    const small = document.createElement("span");
    small.className = "unit";
    small.textContent = unit;
    title.append(small);
    this.head = document.createElement("div");
    this.head.className = "head";
    this.legend = document.createElement("ul");
    this.legend.className = "legend";
    this.head.append(title, this.legend);
    this.plot = document.createElement("div");
    this.plot.className = "plot";
    this.plot.setAttribute("role", "img");
    this.plot.setAttribute("aria-labelledby", title.id);
    this.figure.append(this.head, this.plot);
    place.append(this.figure);
    new ResizeObserver(() => this.chart?.setSize(this.size())).observe(this.plot);
  }

  size() {
    return { width: Math.max(this.plot.clientWidth, 50), height: Math.max(this.plot.clientHeight, 50) };
  }

  /** `options` has scales, axes and series of uPlot; everything else is the same for all. */
  make(options, data) {
    this.chart?.destroy();
    this.chart = new uPlot({
      ...this.size(), legend: { show: false }, padding: [8, 18, 0, 0],
      cursor: { y: false, drag: { x: false, y: false }, points: { show: false }, sync: { key: options.sync ?? "time" } },
      ...options,
    }, data, this.plot);
  }

  /** Names with their colours, made once; their numbers change. Where there are several, each hides and shows. */
  names(names) {
    this.legend.replaceChildren(...names.map(([name, tint], i) => {
      const item = document.createElement("li"), swatch = document.createElement("i"), value = document.createElement("span");
      const inner = document.createElement(names.length > 1 && this.toggle ? "button" : "span");
      inner.style.setProperty("--colour", tint);
      value.className = "number";
      inner.append(swatch, `${name} `, value);
      if (inner.localName === "button") inner.onclick = () => this.toggle(i, !this.channels[i].hidden);
      item.append(inner);
      return item;
    }));
    this.values = [...this.legend.querySelectorAll("span.number")];
  }

  say(texts) {
    texts.forEach((text, i) => { if (this.values[i].textContent !== text) this.values[i].textContent = text; });
  }
}

/** Channels over time: the mean as a line over the band from least to greatest. */
class TimePanel extends Panel {
  constructor(place, { channels, range, smooth, places, points, axis, factor, ...about }) {
    super(place, about);
    Object.assign(this, { channels, range, smooth, places, points, axis, factor: factor ?? 1 });
    this.theme();
  }

  theme() {
    const series = [{}], bands = [];
    this.channels.forEach(({ tint, faint }) => {
      const stroke = tint();
      const none = { paths: () => null, points: { show: false } };
      const dots = { paths: () => null, points: { show: true, size: 3, width: 0, fill: stroke } };
      const line = { stroke, width: faint ? 3 : 1.5, points: { show: false } };
      series.push(this.points ? dots : line);
      if (this.smooth || this.points || faint) return;
      series.push({ ...none, stroke: "transparent", paths: undefined }, { ...none, stroke: "transparent", paths: undefined });
      bands.push({ series: [series.length - 1, series.length - 2], fill: `color-mix(in srgb, ${stroke} 22%, transparent)` });
    });
    const values = (_, splits) => splits.map(clock);
    this.make({
      series, bands,
      scales: { x: { time: false, range: () => view.ends() }, y: { range: this.range } },
      axes: [axis({ values, size: 24, space: 70 }), axis({ size: 46, space: 28, ...this.axis })],
    }, view.empty(series.length));
    this.names(this.channels.map(({ name, tint }) => [name, tint()]));
    this.channels.forEach((channel, i) => this.toggle(i, channel.hidden));
  }

  /** Shows a channel or not; its number stays. */
  toggle(i, hidden) {
    const [columns, button] = [this.columns(), this.legend.querySelectorAll("button")[i]];
    this.channels[i].hidden = hidden;
    button?.setAttribute("aria-pressed", String(!hidden));
    const first = 1 + this.channels.slice(0, i).reduce((sum, channel) => sum + columns(channel), 0);
    for (let at = first; at < first + columns(this.channels[i]); at++) this.chart.setSeries(at, { show: !hidden });
  }

  columns() {
    return ({ faint }) => (this.smooth || this.points || faint ? 1 : 3);
  }

  draw() {
    const data = [view.time];
    const scaled = (column) => (this.factor === 1 ? column : column.map((value) => (value == null ? null : this.factor * value)));
    for (const { at, faint } of this.channels) {
      data.push(scaled(this.smooth ? trailing(view.mean[at], view.smoothed()) : view.mean[at]));
      if (!this.smooth && !this.points && !faint) data.push(scaled(view.low[at]), scaled(view.high[at]));
    }
    this.chart.setData(data);
    const at = this.chart.cursor.idx ?? view.time.length - 1;
    let next = 1;
    this.say(this.channels.map((channel) => {
      const value = data[next]?.[at];
      next += this.columns()(channel);
      return shown(value, this.places ?? digits(value));
    }));
  }
}

/** Mean of the last `n` values at each place. */
function trailing(values, n) {
  let sum = 0, count = 0;
  return values.map((value, i) => {
    if (value != null) { sum += value; count += 1; }
    if (i >= n && values[i - n] != null) { sum -= values[i - n]; count -= 1; }
    return value == null || !count ? null : sum / count;
  });
}

/** Heater bits: one row an element, the darker the longer it is at its high level. */
class HeaterPanel extends Panel {
  constructor(place, about) {
    super(place, about);
    this.channels = about.channels;
    this.theme();
  }

  theme() {
    const count = this.channels.length, names = this.channels.map(({ name }) => name);
    const paint = (chart) => {
      const { ctx } = chart, { time } = view;
      const tall = Math.abs(chart.valToPos(1, "y", true) - chart.valToPos(0, "y", true));
      ctx.save();
      ctx.beginPath();
      ctx.rect(chart.bbox.left, chart.bbox.top, chart.bbox.width, chart.bbox.height);
      ctx.clip();
      this.channels.forEach(({ at, tint }, row) => {
        ctx.fillStyle = tint();
        const top = chart.valToPos(count - row, "y", true) + 0.14 * tall;
        for (let i = 0; i < time.length; i++) {
          const duty = view.mean[at][i];
          if (!duty) continue;
          const left = chart.valToPos(time[i], "x", true);
          const right = chart.valToPos(Math.min(time[i + 1] ?? Infinity, time[i] + view.bucket_s), "x", true);
          ctx.globalAlpha = duty;
          ctx.fillRect(left, top, Math.max(right - left, 1), 0.72 * tall);
        }
      });
      ctx.restore();
    };
    this.make({
      series: [{}, { paths: () => null, points: { show: false } }],
      scales: { x: { time: false, range: () => view.ends() }, y: { range: () => [0, count] } },
      axes: [
        axis({ values: (_, splits) => splits.map(clock), size: 24, space: 70 }),
        axis({ size: 62, splits: () => names.map((_, i) => i + 0.5), values: () => [...names].reverse(), grid: { show: false } }),
      ],
      hooks: { draw: [paint] },
    }, view.empty(2));
    this.names([["high for", "transparent"]]);
  }

  draw() {
    this.chart.setData([view.time, view.time.map(() => null)]);
    const shares = this.channels.map(({ at }) => trailing(view.mean[at], view.smoothed()).at(-1));
    this.say([shares.map((share) => (share == null ? "–" : `${Math.round(100 * share)} %`)).join(" · ")]);
  }
}

/** Noise: amplitude density of one channel over frequency, both logarithmic. */
class SpectrumPanel extends Panel {
  constructor(place, about) {
    super(place, about);
    this.last = { frequency: [0.1, 1], density: [null, null] };
    this.select = document.createElement("select");
    this.select.setAttribute("aria-label", "Channel of the noise spectrum");
    this.head.replaceChild(this.select, this.legend);
    this.unit = this.head.querySelector(".unit");
    this.theme();
  }

  theme() {
    const isDecade = (value) => Math.abs(Math.log10(value) % 1) < 1e-6;
    const values = (_, splits) => splits.map((value) => (isDecade(value) ? exponent(value) : ""));
    // Lines between the decades only where there is room.
    const filter = (_, splits) => splits.map((value) => (isDecade(value) || splits.at(-1) / splits[0] < 2e3 ? value : null));
    this.make({
      sync: "frequency",
      series: [{}, { stroke: colour(0), width: 1.5, points: { show: false } }],
      scales: { x: { time: false, distr: 3 }, y: { distr: 3 } },
      axes: [axis({ size: 24, space: 40, values, filter }), axis({ size: 46, space: 16, values, filter })],
    }, [this.last.frequency, this.last.density]);
  }

  draw(message) {
    this.last = { frequency: message.frequency_hz, density: message.density };
    this.unit.textContent = `${message.unit}/√Hz over Hz`;
    this.chart.setData([this.last.frequency, this.last.density]);
  }
}

const exponent = (value) => {
  const power = Math.round(Math.log10(value));
  if (power >= -2 && power <= 3) return String(10 ** power);
  return "10" + [...String(power)].map((sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]).join("");
};
