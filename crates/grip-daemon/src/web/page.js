// Draws the messages of /events; what stands in them: live.rs. Nothing is ever sent to gripd.
"use strict";

const KEEP_S = 600;      // of what was received
const GAP_S = 0.3;       // longer without a point: the lines are open
const QUIET_MS = 2000;   // longer without a message: gripd is gone
const EVIDENCE = [1e-6, 1e-4, 0.01, 1, 100];
const WORDS = {idle: "IDLE", moving: "MOVING", holding: "HELD", slipping: "SLIPPING"};
const OBJECT_LOST = 0x0201;
const BLANK = {forces_n: []};

const at = id => document.getElementById(id);
const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const number = (value, unit = " N") => value == null ? "–" : value.toFixed(2).replace("-0.00", "0.00") + unit;

let points = [];
let live = null;         // the last message
let heard_ms = 0;        // when it came
let shown_s = 30;
let span_s = [0, 10];    // of the plots
let paused = false;
let plots = [];

function take(message) {
    // Another gripd, or a device that has restarted: another course of time.
    if (String(message.run) !== String(live?.run)) points = [];
    live = message;
    heard_ms = performance.now();
    for (const point of message.points) {
        const last_s = points.at(-1)?.t_s ?? -Infinity;
        // The first message of a connection repeats what may be known.
        if (point.t_s <= last_s) continue;
        if (points.length && point.t_s > last_s + GAP_S) points.push({...BLANK, t_s: last_s + 1e-3});
        points.push(point);
    }
    if (points[0]?.t_s < points.at(-1)?.t_s - 1.1 * KEEP_S) points = points.filter(point => point.t_s > points.at(-1).t_s - KEEP_S);
}

// The word for people, and what is wrong where something is.
function state() {
    if (!live || performance.now() - heard_ms > QUIET_MS) return ["NO GRIPD", "no answer of gripd, or four pages look already; trying again"];
    const {link, pipeline, healthy} = live;
    if (!healthy && !["stream", "degraded"].includes(link.state)) return ["NO GRIPPER", link.closed ?? "waiting for it"];
    if (!healthy || !pipeline) return ["NO SAMPLES", `nothing usable for ${number(pipeline?.age_s, " s")}`];
    const ill = Object.entries(pipeline.health).filter(([, health]) => !["good", "absent"].includes(health));
    const wrong = [...ill.map(pair => pair.join(" ") + "."), live.dry_run ? "Dry run: no force is commanded." : ""];
    if (link.gripper_fault) wrong.unshift(`fault ${link.gripper_fault.toString(16).padStart(4, "0")}: ${live.fault ?? "not a listed one"}`);
    // A quiet sensor without any force says nothing of an object.
    const scene = pipeline.scene === "holding" && pipeline.command_n == null && pipeline.applied_n == null ? "idle" : pipeline.scene;
    const word = link.gripper_fault === OBJECT_LOST ? "DROPPED" : link.gripper_fault ? "FAULT" : WORDS[scene];
    return [word, wrong.filter(Boolean).join(" ")];
}

function words() {
    const [word, wrong] = state();
    const pointer_s = plots.map(plot => plot.data[0][plot.cursor.idx]).find(t_s => t_s != null);
    const point = (pointer_s == null ? points.at(-1) : points.find(point => point.t_s === pointer_s)) ?? BLANK;
    const [command, applied, low, need, high] = point.forces_n;
    const texts = {
        word, command: number(command), applied: number(applied), slips: live?.slips ?? "–",
        need: number(need) + (need == null ? "" : ` (${number(low, "")} – ${number(high, "")})`),
        ratio: number(need > 0 && command != null ? command / need : null, ""),
        statistic: point.statistic < 0.01 && point.statistic != null ? "< 0.01" : point.statistic > 1000 ? "> 1000" : number(point.statistic, ""),
        time: pointer_s == null ? "" : `at the pointer: ${pointer_s.toFixed(2)} s`,
        link: (live ? `${live.link.port}, link: ${live.link.state}` : "") + (live && wrong ? "; " : "") + wrong,
        version: live ? "gripd " + live.version : "",
    };
    for (const [id, text] of Object.entries(texts)) if (at(id).textContent !== String(text)) at(id).textContent = text;
    at("word").className = Object.keys(WORDS).find(scene => WORDS[scene] === word) ?? "fault";
    at("link").className = wrong ? "bad" : "";
    document.title = `${word} ${texts.command} - gripd`;
    const lines = live?.events ?? [];
    if (at("events").textContent === lines.join("")) return;
    at("events").replaceChildren(...lines.map(line => Object.assign(document.createElement("li"), {textContent: line})));
}

// Slips as a wash over a plot; above that of the force, a lane of what the grasp is doing.
function shade(plot, lane) {
    const {ctx, bbox: {left, top, width, height}} = plot;
    const runs = (key, paint) => {
        for (let i = 2, from = 1; i <= points.length; i++) {
            if (points[i]?.[key] === points[from][key] && i < points.length) continue;
            const [begin, end] = [points[from - 1].t_s, points[i - 1].t_s]
                .map(t_s => Math.min(Math.max(plot.valToPos(t_s, "x", true), left), left + width));
            if (points[from][key] && end > begin) paint(points[from][key], begin, end - begin);
            from = i;
        }
    };
    ctx.save();
    if (lane) runs("scene", (scene, begin, length) => {
        ctx.fillStyle = colour(scene);
        ctx.fillRect(begin, top - 8 * devicePixelRatio, length, 6 * devicePixelRatio);
    });
    ctx.globalAlpha = 0.22;
    ctx.fillStyle = colour("slipping");
    runs("slip", (_, begin, length) => ctx.fillRect(begin, top, length, height));
    ctx.restore();
}

// The needed force of an object of which nothing is known is wide: it does not press the others down.
function forces() {
    const seen = points.filter(point => point.t_s >= span_s[0] && point.t_s <= span_s[1]);
    const most = column => seen.reduce((most, point) => Math.max(most, point.forces_n[column] ?? 0), 0);
    const forces_n = Math.max(most(0), most(1), 1);
    return [0, 1.1 * Math.max(forces_n, Math.min(most(4), 1.6 * forces_n))];
}

function plot(id, y, series, more) {
    const axis = {stroke: colour("weak"), grid: {stroke: colour("grid"), width: 1}, ticks: {show: false}, font: "12px system-ui, sans-serif"};
    return new uPlot({
        width: at(id).clientWidth, height: at(id).clientHeight, padding: [14, 14, 0, 0], legend: {show: false},
        scales: {x: {time: false, range: () => span_s}, y},
        axes: [{...axis, size: 28, values: (_, ticks) => ticks.map(tick => tick + " s")}, {...axis, size: 56, ...more.axis}],
        cursor: {sync: {key: "grip"}, drag: {x: false, y: false}, points: {show: false}},
        series: [{}, ...series.map(([name, width, dash]) => ({stroke: colour(name), width, dash, points: {show: false}}))],
        bands: more.bands, hooks: {drawClear: [plot => shade(plot, more.bands)], setCursor: [words]},
    }, [[], ...series.map(() => [])], at(id));
}

function build() {
    plots.forEach(plot => plot.destroy());
    plots = [
        plot("force", {range: forces}, [["need", 0], ["need", 0], ["need", 1.5, [6, 3]], ["applied", 1.5], ["command", 2]],
            {bands: [{series: [1, 2], fill: colour("need") + "40"}]}),
        plot("evidence", {distr: 3, range: () => [EVIDENCE[0], EVIDENCE.at(-1)]}, [["statistic", 1.5], ["limit", 1.5, [6, 4]]],
            {axis: {splits: () => EVIDENCE, filter: (_, ticks) => ticks, values: () => ["1e-6", "1e-4", "0.01", "1", "100"]}}),
    ];
    draw();
}

function draw() {
    if (!paused) {
        // Without samples time goes on.
        const age_s = live?.pipeline?.age_s > 0.5 ? live.pipeline.age_s : 0;
        const end_s = (points.at(-1)?.t_s ?? 0) + age_s;
        const begin_s = Math.max(end_s - shown_s, points[0]?.t_s ?? 0);
        span_s = [begin_s, Math.max(end_s, begin_s + 10)];
        const t_s = points.map(point => point.t_s);
        plots[0].setData([t_s, ...[4, 2, 3, 1, 0].map(column => points.map(point => point.forces_n[column] ?? null))]);
        const evidence = points.map(({statistic: times}) =>
            times == null ? null : Math.min(Math.max(times, EVIDENCE[0]), EVIDENCE.at(-1)));
        plots[1].setData([t_s, evidence, t_s.map(() => 1)]);
    }
    words();
}

function connect() {
    const source = new EventSource("/events");
    source.onmessage = event => {
        take(JSON.parse(event.data));
        if (!document.hidden) draw();
    };
    // A browser does not try again what was refused, because four pages are open.
    source.onerror = () => source.readyState === EventSource.CLOSED && setTimeout(connect, 2000);
}

for (const seconds of [10, 30, 120, KEEP_S]) {
    const input = Object.assign(document.createElement("input"), {type: "radio", name: "window", checked: seconds === shown_s});
    input.onchange = () => { shown_s = seconds; draw(); };
    const label = document.createElement("label");
    label.append(input, seconds < 60 ? ` ${seconds} s` : ` ${seconds / 60} min`);
    at("windows").append(label);
}
at("pause").onchange = event => { paused = event.target.checked; draw(); };
new ResizeObserver(() => plots.forEach(({root: {parentElement: room}}, i) =>
    plots[i].setSize({width: room.clientWidth, height: room.clientHeight}))).observe(at("force"));
matchMedia("(prefers-color-scheme: light)").addEventListener("change", build);
setInterval(words, 500);
build();
connect();
