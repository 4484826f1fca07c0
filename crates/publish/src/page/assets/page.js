"use strict";
// The page: keeps what the server sends of a fixed window, and sends what people ask for.

const at = (id) => document.getElementById(id);
const set = (id, text) => { const place = at(id); if (place.textContent !== text) place.textContent = text; };

/** The columns of the window: one entry a bucket, each channel's mean, least and greatest in it. */
const view = {
  window_s: 60, bucket_s: 0.1, time: [], ids: [], from: [], mean: [], low: [], high: [], latest_s: 0,
  clear(channels) {
    const columns = () => Array.from({ length: channels }, () => []);
    Object.assign(this, { time: [], ids: [], from: [], mean: columns(), low: columns(), high: columns(), latest_s: 0 });
  },
  ends() { return [this.latest_s - this.window_s, this.latest_s]; },
  empty(columns) { return Array.from({ length: columns }, () => []); },
  /** Buckets over which a power or a bit is averaged. */
  smoothed() { return Math.max(1, Math.round(this.window_s / 30 / this.bucket_s)); },
  columns() { return [this.time, this.ids, this.from, ...this.mean, ...this.low, ...this.high]; },
  add({ id, time_s, from_deg, mean, low, high }) {
    // The last bucket comes again until it is full.
    if (this.ids.at(-1) === id) this.columns().forEach((column) => column.pop());
    this.ids.push(id);
    this.time.push(time_s);
    this.from.push(from_deg);
    mean.forEach((value, i) => { this.mean[i].push(value); this.low[i].push(low[i]); this.high[i].push(high[i]); });
    this.latest_s = Math.max(time_s, this.latest_s);
    let old = 0;
    while (this.time[old] < this.latest_s - 1.02 * this.window_s) old += 1;
    if (old) this.columns().forEach((column) => column.splice(0, old));
  },
};

let layout = null, panels = [], spectrum = null, source = null, chosen = 0, now = null, dirty = false, roseAt = 0;

// ---- what comes

function listen() {
  source?.close();
  const query = new URLSearchParams({ window_s: at("window").value, spectrum: chosen });
  source = new EventSource(`events?${query}`);
  const on = (name, what) => source.addEventListener(name, (message) => what(JSON.parse(message.data)));
  on("layout", begin);
  on("rows", (message) => { now = message; message.buckets.forEach((bucket) => view.add(bucket)); dirty = true; show(); });
  on("event", tell);
  on("spectrum", (message) => spectrum?.draw(message));
  on("ended", ({ text }) => { source.close(); link("ended"); tell({ text, kind: "ended", time_s: null }); });
  source.onerror = () => link("no answer: is anemo running?");
  source.onopen = () => link("connected");
}

function link(text) {
  set("link", text);
  at("link").className = text === "connected" || text === "ended" ? "" : "bad";
}

function begin(message) {
  const same = layout && JSON.stringify(layout.channels) === JSON.stringify(message.channels);
  layout = message;
  Object.assign(view, { window_s: layout.window_s, bucket_s: layout.bucket_s });
  view.clear(layout.channels.length);
  at("events").replaceChildren();
  document.title = `${layout.title} – anemo`;
  set("title", layout.title);
  set("about", [layout.head, layout.board, rate(1 / layout.sample_period_s)].filter(Boolean).join(" · "));
  set("rose-caption", `where it comes from, last ${at("window").selectedOptions[0].text}`);
  at("actions").hidden = at("set-point").hidden = at("mark").hidden = !layout.commands;
  if (same) return;
  at("element").replaceChildren(...layout.elements.map((name) => new Option(name)));
  build();
}

const rate = (hz) => (hz >= 1000 ? `${+(hz / 1000).toPrecision(3)} kHz` : `${+hz.toPrecision(3)} Hz`);

function build() {
  const channels = layout.channels.map((channel, index) => ({ ...channel, at: index }));
  const of = (quantity) => channels.filter((channel) => channel.quantity === quantity)
    // The gas beside the head is far from the elements: it would flatten them.
    .map(({ at, of, place }) => ({ at, name: of, hidden: of === "reference", tint: () => colour(place ?? 0) }));
  const single = (quantity, name, tint, faint) => of(quantity).map((channel) => ({ ...channel, name, tint: () => css(tint), faint }));
  const place = at("charts");
  place.querySelectorAll(".chart").forEach((old) => old.remove());
  const events = at("events").closest("section");
  panels = [];
  const add = (Kind, about) => { if (about.channels.length) panels.push(new Kind(place, about)); };
  add(TimePanel, { id: "speed-chart", name: "Wind speed", unit: "m/s", range: fromZero(1), places: 2,
    channels: [...single("true_wind_speed_m_s", "true", "--truth", true), ...single("wind_speed_m_s", "estimate", "--c0")] });
  if (of("wind_speed_m_s").length) {
    panels.push(new DirectionPanel(place, { id: "direction-chart", name: "Wind direction", unit: "from" }));
  }
  add(TimePanel, { id: "temperature-chart", name: "Temperature", unit: "°C", range: range(0.05), places: 2, channels: of("temperature_c") });
  add(TimePanel, { id: "conductance-chart", name: "Conductance to the gas", unit: "mW/K", factor: 1e3, range: fromZero(1e-6), channels: of("conductance_w_k") });
  add(TimePanel, { id: "power-chart", name: "Power", unit: `mW, mean of ${+(view.window_s / 30).toPrecision(2)} s`, factor: 1e3, range: fromZero(1e-3), smooth: true, channels: of("power_w") });
  spectrum = new SpectrumPanel(place, { id: "spectrum-chart", name: "Noise", unit: "" });
  spectrum.select.replaceChildren(...channels.filter(({ noisy }) => noisy).map((channel) => new Option(channel.name, channel.at)));
  spectrum.select.addEventListener("change", () => { chosen = spectrum.select.value; listen(); });
  chosen = spectrum.select.value;
  add(HeaterPanel, { id: "heater-chart", name: "Heaters", unit: "", channels: of("heater") });
  place.append(events);
}

/** The direction from which it blows is a circle: points, of the mean vector of each bucket. */
class DirectionPanel extends TimePanel {
  constructor(place, about) {
    super(place, { ...about, points: true, places: 0, range: () => [0, 360], channels: [{ name: "", tint: () => css("--c0") }],
      axis: { splits: () => [0, 90, 180, 270, 360], values: () => ["N", "E", "S", "W", "N"] } });
  }
  draw() {
    this.chart.setData([view.time, view.from]);
    this.say([`${shown(view.from[this.chart.cursor.idx ?? view.from.length - 1], 0)}°`]);
  }
}

// ---- what is shown

const WORDS = { running: "Running", standby: "Standby", testing: "Self-test", tripped: "Tripped" };

/** What may not wait for the next picture: state, trip, losses. */
function show() {
  const { state, trip, lost, missed } = now;
  const short = state.startsWith("tripped") ? "tripped" : state;
  if (at("state").dataset.state !== short) {
    at("state").dataset.state = short;
    set("state", WORDS[short] ?? state);
  }
  at("alarm").hidden = short !== "tripped";
  set("alarm", short === "tripped" ? `Tripped: ${trip ?? state}. Heaters are low.` : "");
  set("lost", String(lost));
  set("missed", String(missed));
  at("lost").className = `number${lost ? " bad" : ""}`;
}

function tell({ time_s, kind, text }) {
  const item = document.createElement("li"), time = document.createElement("time"), what = document.createElement("span");
  item.className = kind;
  time.textContent = time_s == null ? "" : clock(time_s);
  what.textContent = text;
  item.append(time, what);
  at("events").prepend(item);
  while (at("events").children.length > 200) at("events").lastChild.remove();
}

function draw(stamp) {
  requestAnimationFrame(draw);
  if (!dirty || document.hidden) return;
  dirty = false;
  panels.forEach((panel) => panel.draw());
  set("time", clock(now.time_s));
  // A recording may not say when it began.
  set("utc", now.utc_ms > 1e12 ? `${new Date(now.utc_ms).toISOString().slice(0, 19).replace("T", " ")} UTC` : "");
  wind();
  if (stamp - roseAt > 1000) { roseAt = stamp; rose(); }
}

function wind() {
  const { wind, true_from_deg, flags } = now;
  const has = wind != null && wind.from_deg != null;
  set("speed", shown(wind?.speed_m_s, 2));
  set("speed-u", wind?.speed_u_m_s == null ? "" : `± ${shown(wind.speed_u_m_s, 2)}`);
  set("from", has ? `${shown(wind.from_deg, 0)}°` : "–");
  set("from-word", has ? POINTS[Math.round(wind.from_deg / 22.5) % 16] : "");
  turn("arrow", has ? wind.from_deg : null);
  turn("true-arrow", true_from_deg);
  const names = flags == null ? [] : layout.flags.filter((_, bit) => flags >> bit & 1);
  const key = flags == null ? "none" : names.join();
  if (at("flags").dataset.key === key) return;
  at("flags").dataset.key = key;
  const word = flags == null ? "no wind estimate" : "no quality flag";
  at("flags").replaceChildren(...(names.length ? names : [word]).map((name) => {
    const item = document.createElement("li");
    item.textContent = name;
    item.className = names.length ? "bad" : "quiet";
    return item;
  }));
}

const POINTS = "N NNE NE ENE E ESE SE SSE S SSW SW WSW W WNW NW NNW".split(" ");

function turn(id, from_deg) {
  at(id).toggleAttribute("hidden", from_deg == null);
  if (from_deg != null) at(id).setAttribute("transform", `rotate(${from_deg.toFixed(1)})`);
}

/** Share of the window's buckets from each of 16 sectors, by four classes of speed. */
function rose() {
  const speeds = view.mean[layout.channels.findIndex(({ quantity }) => quantity === "wind_speed_m_s")];
  if (!speeds) return;
  const most = Math.max(0.1, ...speeds.filter((speed) => speed != null));
  const step = nice(most / 4), counts = Array.from({ length: 16 }, () => [0, 0, 0, 0]);
  let all = 0;
  speeds.forEach((speed, i) => {
    const from = view.from[i];
    if (speed == null || from == null) return;
    counts[Math.round(from / 22.5) % 16][Math.min(3, Math.floor(speed / step))] += 1;
    all += 1;
  });
  const greatest = Math.max(1, ...counts.map((classes) => classes.reduce((a, b) => a + b)));
  const petals = [];
  counts.forEach((classes, sector) => {
    let inner = 0;
    classes.forEach((count, level) => {
      if (!count) return;
      // Areas, not radii, are as the counts.
      const outer = inner + count, radius = (n) => 92 * Math.sqrt(n / greatest);
      const petal = document.createElementNS("http://www.w3.org/2000/svg", "path");
      petal.setAttribute("d", wedge(22.5 * sector, radius(inner), radius(outer)));
      petal.setAttribute("fill", `color-mix(in srgb, var(--c0) ${25 + 25 * level}%, var(--paper))`);
      petals.push(petal);
      inner = outer;
    });
  });
  at("petals").replaceChildren(...petals);
  const text = at("window").selectedOptions[0].text;
  set("rose-caption", all ? `from, last ${text}; shades of ${+step.toPrecision(2)} m/s` : `from, last ${text}`);
}

const nice = (least) => {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 2.5, 5, 10].find((step) => step * power >= least * 0.999);
};

function wedge(middle_deg, inner, outer) {
  const point = (deg, radius) => {
    const angle = (deg * Math.PI) / 180;
    return `${(radius * Math.sin(angle)).toFixed(2)} ${(-radius * Math.cos(angle)).toFixed(2)}`;
  };
  const [a, b] = [middle_deg - 10, middle_deg + 10];
  return `M${point(a, inner)}L${point(a, outer)}A${outer} ${outer} 0 0 1 ${point(b, outer)}L${point(b, inner)}A${inner} ${inner} 0 0 0 ${point(a, inner)}Z`;
}

// ---- what is asked for

let silence = 0;

async function ask(request) {
  const say = (text, refused) => {
    set("answer", text);
    at("answer").className = refused ? "answer refused" : "answer";
    clearTimeout(silence);
    silence = setTimeout(() => set("answer", ""), refused ? 20_000 : 6_000);
  };
  say("…", false);
  try {
    const response = await fetch("command", {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(request),
    });
    const { done, refused } = await response.json();
    say(refused ?? done, refused != null);
  } catch {
    say("anemo does not answer", true);
  }
}

at("actions").addEventListener("click", ({ target }) => {
  if (target.dataset.command) ask(target.dataset.command);
});
at("set-point").addEventListener("submit", (event) => {
  event.preventDefault();
  ask({ set_point: { element: at("element").value, temperature_c: Number(at("celsius").value) } });
});
at("mark").addEventListener("submit", (event) => {
  event.preventDefault();
  ask({ mark: { text: at("text").value } });
  at("text").value = "";
});
at("window").addEventListener("change", () => { layout = null; listen(); });

function theme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  at("theme").setAttribute("aria-pressed", String(dark));
  panels.forEach((panel) => panel.theme());
  spectrum?.theme();
  dirty = now != null;
}
const preferred = matchMedia("(prefers-color-scheme: dark)");
preferred.addEventListener("change", () => theme(preferred.matches));
at("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme !== "dark"));
theme(preferred.matches);

listen();
requestAnimationFrame(draw);
